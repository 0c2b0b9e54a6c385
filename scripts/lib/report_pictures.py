# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of a report that scripts/picture does not draw."""
import re

import matplotlib.pyplot as plt
import numpy as np

import field_pictures
from coupled_run import CoupledRun
from result_files import NothingToDraw, read_series

COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:red", "tab:purple")


def inflated(run: CoupledRun):
    """The last canopy that a stage before the coupled run wrote."""
    files = [file for file in sorted(run.root.rglob("structure_*.*vtu")) if run.folder not in file.parents]
    if not files:
        raise NothingToDraw(f"no structure_*.vtu of an earlier stage below {run.root}")
    figure, axes = plt.subplots(figsize=(5.6, 7.6))
    field_pictures.draw_structure(files[-1], axes)
    figure.tight_layout()
    return figure


def last_state(run: CoupledRun):
    return field_pictures.canopy(run.folder)


def instants(run: CoupledRun, count: int = 4):
    """Flow and canopy at `count` instants, equally spaced from the first to the last that has both."""
    step_of = {part: {int(re.search(r"_(\d+)\.p?vtu$", file.name).group(1)): file
                      for file in run.folder.glob(f"{part}/{part}_*.*vtu")} for part in ("fluid", "structure")}
    steps = sorted(step_of["fluid"].keys() & step_of["structure"].keys())
    if not steps:
        raise NothingToDraw("no step has the fields of both the fluid and the structure")
    chosen = sorted({steps[round(i * (len(steps) - 1) / max(1, count - 1))] for i in range(count)})
    drag = run.drag()
    figure, axes = plt.subplots(1, len(chosen), figsize=(3.6 * len(chosen), 5.2), squeeze=False)
    for axis, step in zip(axes[0], chosen):
        field_pictures.draw_flow(step_of["fluid"][step], step_of["structure"][step], axis)
        time = drag["time"][step - 1] if 0 < step <= len(drag["time"]) else np.nan
        axis.set_title(f"step {step}" + (f", t = {time:.4g}" if np.isfinite(time) else ""))
    figure.tight_layout()
    return figure


def axis_of_drag(drag: dict[str, np.ndarray]) -> str:
    """The component that carries most of the force."""
    return max("xyz", key=lambda component: np.abs(drag[f"force_{component}"]).mean())


def drag_of(runs: list[CoupledRun]):
    figure, axes = plt.subplots(figsize=(8, 4.2))
    for run, colour in zip(runs, COLOURS):
        drag = run.drag()
        axes.plot(drag["time"], drag[f"force_{axis_of_drag(drag)}"], color=colour, lw=1.6, label=run.name)
    weight = weight_of(runs[0])
    if weight is not None:
        axes.axhline(weight, color="0.3", ls="--", lw=1.2, label="weight of the system")
    axes.set_xlabel("time")
    axes.set_ylabel("force on the canopy")
    axes.legend(frameon=False)
    figure.tight_layout()
    return figure


def weight_of(run: CoupledRun) -> float | None:
    """Where the structure writes its weight."""
    try:
        series = run.structure()
    except NothingToDraw:
        return None
    return abs(float(series["weight_z"][-1])) if "weight_z" in series else None


def spectrum(runs: list[CoupledRun]):
    figure, axes = plt.subplots(figsize=(8, 3.8))
    for run, colour in zip(runs, COLOURS):
        drag = run.drag()
        half = slice(len(drag["time"]) // 2, None)
        time, force = drag["time"][half], drag[f"force_{axis_of_drag(drag)}"][half]
        if len(time) < 16:
            raise NothingToDraw(f"{run.name} has {2 * len(time)} steps: too few for a spectrum")
        even = np.linspace(time[0], time[-1], len(time))  # steps may have been halved
        force = np.interp(even, time, force)
        trend = np.polyval(np.polyfit(even, force, 1), even)
        window = np.hanning(len(even))
        amplitude = np.abs(np.fft.rfft((force - trend) * window)) * 2 / window.sum()
        axes.plot(np.fft.rfftfreq(len(even), even[1] - even[0])[1:], amplitude[1:], color=colour, lw=1.4, label=run.name)
    axes.set_yscale("log")
    axes.set_xlabel("frequency")
    axes.set_ylabel("amplitude of the drag")
    axes.legend(frameon=False)
    figure.tight_layout()
    return figure


def vectors(series: dict[str, np.ndarray], pattern: str) -> dict[str, np.ndarray]:
    """{name: {steps, 3}} of all columns NAME_x, NAME_y, NAME_z whose name matches."""
    names = [column[:-2] for column in series if column.endswith("_x") and re.fullmatch(pattern, column[:-2])]
    return {name: np.column_stack([series[f"{name}_{c}"] for c in "xyz"]) for name in names}


def draw_vectors(time: np.ndarray, found: dict[str, np.ndarray], label: str):
    figure, axes = plt.subplots(len(found), 1, figsize=(8, 1.2 + 2.4 * len(found)), sharex=True, squeeze=False)
    for axis, (name, values) in zip(axes[:, 0], found.items()):
        for component, colour in zip(range(3), ("tab:orange", "tab:green", "tab:blue")):
            axis.plot(time, values[:, component], color=colour, lw=1.4, label="xyz"[component])
        axis.set_ylabel(f"{name}\n{label}")
    axes[0, 0].legend(frameon=False, ncol=3)
    axes[-1, 0].set_xlabel("time")
    figure.align_ylabels()
    figure.tight_layout()
    return figure


def structure_forces(run: CoupledRun):
    series = run.structure()
    found = vectors(series, r"(reaction|line_force)_.*")
    if not found:
        raise NothingToDraw("the structure reports no reaction and no line force")
    return draw_vectors(series["time"], found, "")


def probe_velocities(run: CoupledRun):
    series = read_series(run.folder / "structure", "probes.csv", ["time"])
    found = vectors(series, r".*_velocity")
    if not found:
        raise NothingToDraw("the structure's probes.csv holds no velocity")
    return draw_vectors(series["time"], found, "velocity")


def time_by_process(run: CoupledRun):
    times = run.time_by_process()
    if not times:
        raise NothingToDraw("coupler.log has no line of times: the run has not ended")
    figure, axes = plt.subplots(figsize=(8, 0.6 + 0.45 * len(times)))
    names = list(times)[::-1]
    bars = axes.barh([name.replace("_", " ") for name in names], [times[name] for name in names], color="tab:blue")
    total = sum(times.values())
    axes.bar_label(bars, [f" {times[name]:.0f} s, {100 * times[name] / total:.0f} %" for name in names])
    axes.margins(x=0.15)
    axes.set_xlabel("seconds")
    axes.grid(axis="y", visible=False)
    figure.tight_layout()
    return figure
