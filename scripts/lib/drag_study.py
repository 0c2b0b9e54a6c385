# SPDX-License-Identifier: GPL-3.0-or-later
"""Drag of a fixed canopy against time step and Smagorinsky constant (called by scripts/drag_study)."""
import argparse
import csv
import dataclasses
import pathlib
import re
import subprocess
import sys

import gmsh
import matplotlib.pyplot as plt
import numpy as np

FOLDER = "drag_study"
BATCHES = 5


@dataclasses.dataclass(frozen=True)
class Variant:
    step: float
    constant: float

    @property
    def name(self) -> str:
        return f"step_{self.step:g}_constant_{self.constant:g}"


@dataclasses.dataclass(frozen=True)
class Mean:
    """Drag coefficient on the reference area; `error` is the standard error of the mean by means over equal batches of time."""
    value: float
    error: float
    deviation: float
    smallest: float
    largest: float

    @staticmethod
    def of(values: np.ndarray) -> "Mean":
        batches = np.array([batch.mean() for batch in np.array_split(values, BATCHES)])
        return Mean(values.mean(), batches.std(ddof=1) / np.sqrt(BATCHES), values.std(), values.min(), values.max())


def number(config: str, field: str) -> float:
    """The first value of a field in the text of a config."""
    found = re.search(rf"\b{field}: *([0-9.eE+-]+)", config)
    if not found:
        raise SystemExit(f"drag_study: flow.textproto has no {field}")
    return float(found.group(1))


def config_of(flow: str, variant: Variant, until: float) -> str:
    """The config of a stage `flow` with another step and constant, one semi-discrete phase, and results in its own folder."""
    lines = [line for line in flow.splitlines() if not re.match(r"(phase|output|final_state|averages)\b", line)]
    text = re.sub(r"(smagorinsky: *)[0-9.eE+-]+", rf"\g<1>{variant.constant:g}", "\n".join(lines))
    text = re.sub(r'^mesh: *"([^"]*)"', r'mesh: "../\1"', text, flags=re.MULTILINE)
    steps = round(until / variant.step)
    return (f"{text}\nphase {{ formulation: SEMI_DISCRETE step: {variant.step:g} steps: {steps} }}\n"
            f'output {{ directory: "{variant.name}" field_interval: {steps} }}\n')


def run(folder: pathlib.Path, variant: Variant, options: argparse.Namespace) -> None:
    """Runs the flow of a variant in the study's folder unless it is there."""
    text = config_of((folder.parent / "flow.textproto").read_text(), variant, options.until)
    config, done = folder / f"{variant.name}.textproto", folder / variant.name / "done"
    if done.exists() and config.exists() and config.read_text() == text:
        return
    done.unlink(missing_ok=True)
    config.write_text(text)
    print(f"    {folder.parent.name}: step {variant.step:g}, Smagorinsky constant {variant.constant:g}", file=sys.stderr)
    program = options.bin.resolve() / "fluid_solver"
    with (folder / f"{variant.name}.log").open("w") as log:
        command = ["mpiexec", "--oversubscribe", "-n", str(options.ranks)] if options.ranks > 1 else []
        status = subprocess.run([*command, program, "run", config.name], cwd=folder, stdout=log, stderr=log).returncode
    if status != 0:
        raise SystemExit(f"drag_study: fluid_solver ended with status {status}; see {log.name}")
    done.touch()


def history(folder: pathlib.Path, variant: Variant) -> tuple[np.ndarray, np.ndarray]:
    """Time and drag coefficient on the reference area of the first force of the config."""
    with (folder / variant.name / "forces.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    column = next(name for name in rows[0] if name.endswith("_coefficient_z"))
    return np.array([float(row["time"]) for row in rows]), np.array([float(row[column]) for row in rows])


def projected_area(mesh_file: pathlib.Path) -> float:
    """Area of the canopy's shadow in the stream: the z component of the vector area of canopy_upper, vent left out."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 1)
    gmsh.open(str(mesh_file))
    tag = next(tag for dimension, tag in gmsh.model.getPhysicalGroups(2) if gmsh.model.getPhysicalName(2, tag) == "canopy_upper")
    numbers, points, _ = gmsh.model.mesh.getNodes()
    position = np.zeros((int(numbers.max()) + 1, 3))
    position[numbers] = points.reshape(-1, 3)
    triangles = np.concatenate([gmsh.model.mesh.getElementsByType(2, entity)[1]
                                for entity in gmsh.model.getEntitiesForPhysicalGroup(2, tag)]).reshape(-1, 3)
    gmsh.finalize()
    a, b, c = (position[triangles[:, i]] for i in range(3))
    return abs(0.5 * np.cross(b - a, c - a)[:, 2].sum())


def variants_of(options: argparse.Namespace, flow: str) -> list[Variant]:
    steps = options.steps or [number(flow, "step")]
    constants = options.constants or [number(flow, "smagorinsky")]
    return [Variant(step, constants[0]) for step in steps] + [Variant(steps[0], constant) for constant in constants[1:]]


def study(folder: pathlib.Path, options: argparse.Namespace) -> None:
    flow = (folder.parent / "flow.textproto").read_text()
    mesh = folder.parent / re.search(r'^mesh: *"([^"]*)"', flow, flags=re.MULTILINE).group(1)
    ratio = number(flow, "reference_area") / projected_area(mesh)
    variants = variants_of(options, flow)
    for variant in variants:
        run(folder, variant, options)

    figure, axis = plt.subplots(figsize=(9, 4.2))
    table = []
    for variant in variants:
        time, cd = history(folder, variant)
        mean = Mean.of(cd[time > options.mean_from])
        table.append((variant, mean))
        shown = time > options.until / 30  # without the impulsive start
        axis.plot(time[shown], cd[shown], lw=1.2,
                  label=f"step {variant.step:g}, constant {variant.constant:g}: mean {mean.value:.3f}")
    axis.axvspan(options.mean_from, options.until, color="0.95", zorder=0)
    axis.set_xlabel("time (unit of the case); means are taken in the grey part")
    axis.set_ylabel("drag coefficient, reference area")
    axis.legend(frameon=False)
    axis.set_title(f"Fixed canopy, {folder.parent.name}")
    figure.tight_layout()
    figure.savefig(folder / "drag_study.png", dpi=110)
    write(folder / "drag_study.csv", table, ratio)


def write(file: pathlib.Path, table: list[tuple[Variant, Mean]], ratio: float) -> None:
    """The table as csv, and for the eye on the standard output. `ratio`: reference area over projected area."""
    with file.open("w") as stream:
        print("step,smagorinsky,cd,standard_error,deviation,smallest,largest,cd_projected", file=stream)
        for v, m in table:
            print(v.step, v.constant, m.value, m.error, m.deviation, m.smallest, m.largest, m.value * ratio, sep=",", file=stream)
    print(f"{file.parent.parent.name}: reference area over projected area {ratio:.3f}")
    print("| step | Smagorinsky constant | mean drag coefficient | its standard error | rms about it | smallest, largest | "
          "on the projected area |\n|---:|---:|---:|---:|---:|---:|---:|")
    for v, m in table:
        print(f"| {v.step:g} | {v.constant:g} | {m.value:.3f} | {m.error:.3f} | {m.deviation:.3f} | "
              f"{m.smallest:.3f}, {m.largest:.3f} | {m.value * ratio:.3f} |")


def numbers(text: str) -> list[float]:
    return [float(value) for value in text.split(",")]


def main() -> None:
    parser = argparse.ArgumentParser(prog="scripts/drag_study")
    parser.add_argument("runs", nargs="+", type=pathlib.Path)
    parser.add_argument("--until", type=float, default=60)
    parser.add_argument("--mean-from", type=float)
    parser.add_argument("--steps", type=numbers)
    parser.add_argument("--constants", type=numbers)
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    options = parser.parse_args()
    options.mean_from = options.until / 3 if options.mean_from is None else options.mean_from
    if not 0 <= options.mean_from < options.until:
        parser.error("--mean-from must lie between 0 and --until")
    for run_dir in options.runs:
        if not (run_dir / "flow.textproto").exists():
            parser.error(f"{run_dir} has no flow.textproto: scripts/demo CASE --until fluid_mesh makes it")
        folder = run_dir / FOLDER
        folder.mkdir(exist_ok=True)
        study(folder, options)


if __name__ == "__main__":
    main()
