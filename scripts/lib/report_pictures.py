# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of a report that scripts/picture does not draw."""
import re

import matplotlib.pyplot as plt
import numpy as np

import field_pictures
import impulse
from coupled_run import CoupledRun
from result_files import NothingToDraw, read_series

COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:red", "tab:purple")


def inflated(run: CoupledRun):
    """The last canopy that a stage before the coupled run wrote."""
    files = [file for folder in run.earlier() for file in sorted(folder.rglob("structure_*.*vtu"))
             if not any((parent / "coupling.csv").exists() for parent in file.parents)]
    if not files:
        raise NothingToDraw(f"no structure_*.vtu of an earlier stage below {run.root}")
    figure, axes = plt.subplots(figsize=(5.6, 7.6))
    field_pictures.draw_structure(files[-1], axes)
    figure.tight_layout()
    return figure


def last_state(run: CoupledRun):
    return field_pictures.canopy(run.folder)


def chosen_steps(steps: list[int], times: dict[int, float], count: int, apart: float) -> list[int]:
    """The last step and those before it by `apart` each, nearest; equally spaced ones where the run is too short."""
    last = times.get(steps[-1], np.nan)
    known = [step for step in steps if step in times]
    if known and last - times[known[0]] >= 0.95 * (count - 1) * apart:
        return sorted({min(known, key=lambda step: abs(times[step] - (last - i * apart))) for i in range(count)})
    return sorted({steps[round(i * (len(steps) - 1) / max(1, count - 1))] for i in range(count)})


def instants(run: CoupledRun, count: int = 4, apart: float = 0.63):
    """Flow above, structure below, all in the same window: what falls or rises does so in the pictures."""
    step_of = {part: {int(re.search(r"_(\d+)\.p?vtu$", file.name).group(1)): file
                      for file in run.folder.glob(f"{part}/{part}_*.*vtu")} for part in ("fluid", "structure")}
    steps = sorted(step_of["fluid"].keys() & step_of["structure"].keys())
    if not steps:
        raise NothingToDraw("no step has the fields of both the fluid and the structure")
    coupling = run.coupling()
    times = dict(zip(coupling["step"].astype(int), coupling["time"]))
    chosen = chosen_steps(steps, times, count, apart)
    structures = [step_of["structure"][step] for step in chosen]
    cloth, whole = field_pictures.common_boxes(structures)
    figure, axes = plt.subplots(2, len(chosen), figsize=(3.6 * len(chosen), 9.6), squeeze=False)
    for above, below, step in zip(axes[0], axes[1], chosen):
        field_pictures.draw_flow(step_of["fluid"][step], step_of["structure"][step], above, cloth)
        field_pictures.draw_structure(step_of["structure"][step], below, whole)
        above.set_title(f"step {step}" + (f", t = {times[step]:.4g}" if step in times else ""))
        below.set_title("")
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
    """Where the structure writes its weight and has one."""
    try:
        series = run.structure()
    except NothingToDraw:
        return None
    return abs(float(series["weight_z"][-1])) or None if "weight_z" in series else None


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
    """{name: {steps, 3}} of all columns NAME_x, NAME_y, NAME_z whose name matches; group 1 of the pattern, where it has
    one, is the name, and columns of the same name are averaged."""
    found: dict[str, list[np.ndarray]] = {}
    for column in series:
        match = re.fullmatch(pattern, column[:-2]) if column.endswith("_x") else None
        if match:
            name = match.group(1) if match.groups() else match.group(0)
            found.setdefault(name, []).append(np.column_stack([series[f"{column[:-2]}_{c}"] for c in "xyz"]))
    return {name: np.mean(values, axis=0) for name, values in found.items()}


def draw_vectors(runs: list[tuple[str, np.ndarray, dict[str, np.ndarray]]], label: str):
    """The vectors of the first run; of the others, broken, those of the same names.
    @param runs: name, time, vectors"""
    figure, axes = plt.subplots(len(runs[0][2]), 1, figsize=(8, 1.2 + 2.6 * len(runs[0][2])), sharex=True, squeeze=False)
    for run, (of, time, found) in enumerate(runs):
        for axis, name in zip(axes[:, 0], runs[0][2]):
            for component, colour in zip(range(3), ("tab:orange", "tab:green", "tab:blue")):
                if name in found:
                    axis.plot(time, found[name][:, component], color=colour, lw=1.4, ls="-" if run == 0 else "--",
                              label="xyz"[component] + (f", {of}" if len(runs) > 1 else ""))
            axis.set_ylabel(f"{name}\n{label}")
    axes[0, 0].legend(frameon=False, ncol=3, fontsize="small", loc="lower center", bbox_to_anchor=(0.5, 1))
    axes[-1, 0].set_xlabel("time")
    figure.align_ylabels()
    figure.tight_layout()
    return figure


def of_all(runs: list[CoupledRun], read, pattern: str, missing: str):
    """What draw_vectors takes; runs after the first that have nothing are left out."""
    drawn = []
    for run in runs:
        try:
            series = read(run)
        except NothingToDraw:
            if run is runs[0]:
                raise
            continue
        found = vectors(series, pattern)
        if not found and run is runs[0]:
            raise NothingToDraw(missing)
        drawn.append((run.name, series["time"], found))
    return drawn


def structure_forces(runs: list[CoupledRun]):
    return draw_vectors(of_all(runs, CoupledRun.structure, r"(?:reaction|line_force)_.*",
                               "the structure reports no reaction and no line force"), "")


def probes(run: CoupledRun) -> dict[str, np.ndarray]:
    return read_series(run.folder / "structure", "probes.csv", ["time"])


def probe_velocities(runs: list[CoupledRun]):
    return draw_vectors(of_all(runs, probes, r"(.*?)(?:_\d+)?_velocity", "the structure's probes.csv holds no velocity"),
                        "velocity")


def probe_positions(runs: list[CoupledRun]):
    return draw_vectors(of_all(runs, probes, r"((?!.*_(?:velocity|acceleration)$).*?)(?:_\d+)?",
                               "the structure's probes.csv holds no displacement"), "displacement")


def impulse_balance(run: CoupledRun):
    series = run.structure()
    balance = impulse.vertical_balance(series)
    if balance is None:
        raise NothingToDraw("structure.csv holds no momentum, or not all forces")
    change, total, size = balance
    figure, (above, below) = plt.subplots(2, 1, figsize=(8, 5.6), sharex=True, gridspec_kw={"height_ratios": [2, 1]})
    above.plot(series["time"], change, color="tab:blue", lw=2.4, label="change of momentum")
    above.plot(series["time"], total, color="tab:orange", lw=1.2, ls="--", label="impulse of all forces")
    above.set_ylabel("vertical momentum")
    above.legend(frameon=False)
    below.plot(series["time"], (change - total) / (size or 1.0), color="tab:red", lw=1.4)
    below.set_ylabel("relative\ndifference")
    below.set_xlabel("time")
    figure.align_ylabels()
    figure.tight_layout()
    return figure


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
