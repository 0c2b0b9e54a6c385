# SPDX-License-Identifier: GPL-3.0-or-later
"""A report of a coupled run in one HTML file: report.py RUN_DIR [OTHER_RUN_DIR...] [-o FILE] (called by
scripts/report on a virtual screen)."""
import argparse
import base64
import datetime
import html
import pathlib
import sys

import matplotlib.pyplot as plt
import numpy as np

import impulse
import report_pictures
import series_pictures
from coupled_run import CoupledRun
from pictures import SETTINGS
from result_files import NothingToDraw

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
h1 { margin-bottom: 0; } h2 { margin-top: 2.5rem; border-bottom: 1px solid #ccc; }
table { border-collapse: collapse; } td, th { padding: .2rem .8rem .2rem 0; text-align: left; vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
img { max-width: 100%; } figure { margin: 1rem 0; } figcaption { color: #555; }
pre { background: #f5f5f5; padding: .8rem; overflow-x: auto; font-size: .85rem; }
.missing { color: #777; font-style: italic; } .bad { color: #b00020; font-weight: 600; }
"""


class Report:
    """Collects sections; pictures go into the text and, as PNG, beside it."""

    def __init__(self, folder: pathlib.Path):
        self.folder, self.parts, self.pictures = folder, [], 0
        folder.mkdir(parents=True, exist_ok=True)

    def section(self, title: str):
        self.parts.append(f"<h2>{html.escape(title)}</h2>")

    def text(self, text: str):
        self.parts.append(f"<p>{html.escape(text)}</p>")

    def lines(self, lines: list[str]):
        self.parts.append("<pre>" + html.escape("\n".join(lines)) + "</pre>")

    def table(self, rows: list[tuple[str, str, bool]]):
        cells = "".join(f"<tr><td>{html.escape(name)}</td><td class='number{'' if good else ' bad'}'>{html.escape(value)}"
                        "</td></tr>" for name, value, good in rows)
        self.parts.append(f"<table>{cells}</table>")

    def picture(self, name: str, caption: str, draw):
        try:
            figure = draw()
        except NothingToDraw as reason:
            self.parts.append(f"<p class='missing'>{html.escape(caption)}: left out, {html.escape(str(reason))}</p>")
            print(f"    {name}.png left out: {reason}", file=sys.stderr)
            return
        file = self.folder / f"{name}.png"
        figure.savefig(file)
        plt.close(figure)
        data = base64.b64encode(file.read_bytes()).decode()
        self.parts.append(f"<figure><img alt='{html.escape(name)}' src='data:image/png;base64,{data}'>"
                          f"<figcaption>{html.escape(caption)}</figcaption></figure>")
        self.pictures += 1

    def details(self, title: str, text: str):
        self.parts.append(f"<details><summary>{html.escape(title)}</summary><pre>{html.escape(text)}</pre></details>")

    def write(self, file: pathlib.Path, title: str):
        file.write_text("<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>"
                        f"<title>{html.escape(title)}</title><style>{STYLE}</style></head><body>"
                        + "\n".join(self.parts) + "</body></html>\n")


def figures(run: CoupledRun) -> list[tuple[str, str, bool]]:
    """Name, value, whether it is as it should be."""
    drag, last = run.drag(), run.last_iterations()
    time = drag["time"]
    rows = [("steps", f"{len(time)}, to t = {time[-1]:.5g}", True)]
    if "iterations" in drag:
        rows.append(("coupling iterations a step", f"{drag['iterations'].mean():.2f}, at most {drag['iterations'].max():.0f}",
                     True))
    if "converged" in drag:
        open_steps = time[drag["converged"] != 1]
        shown = ", ".join(f"{t:.5g}" for t in open_steps[:8]) + (", ..." if len(open_steps) > 8 else "")
        rows.append(("steps that did not converge", f"{len(open_steps)}" + (f" (t = {shown})" if shown else ""),
                     len(open_steps) == 0))
    rows.append(("largest residual of a committed step", f"{last['residual_relative'].max():.2e}", True))
    rows.append(("largest force defect between the meshes", f"{run.coupling()['force_defect'].max():.1e}", True))
    settled = slice(len(time) // 2, None)
    for name, label in (("cd", "drag coefficient"), ("force_z", "vertical force on the canopy")):
        if name in drag and np.isfinite(drag[name][settled]).any():
            values = drag[name][settled]
            rows.append((f"{label}, mean of the second half", f"{values.mean():.5g}, rms of its change {values.std():.2g}",
                         True))
    try:
        defect = impulse.largest_defect(run.structure())
    except NothingToDraw:
        defect = None
    if defect is not None:
        rows.append(("change of vertical momentum against the impulse of all forces, largest difference over the "
                     "impulse of the weight (or of all forces)", f"{defect:.2e}", defect <= 0.01))
    return rows


def against_others(runs: list[CoupledRun]) -> list[tuple[str, str, bool]]:
    """Mean drag over the second half of the time that both runs have, against the first run's."""
    rows = []
    for other in runs[1:]:
        both = [run.drag() for run in (runs[0], other)]
        end = min(drag["time"][-1] for drag in both)
        start = max(0.5 * end, *(drag["time"][0] for drag in both))
        means = []
        for drag in both:
            chosen = (drag["time"] >= start) & (drag["time"] <= end)
            means.append(drag[f"force_{report_pictures.axis_of_drag(drag)}"][chosen].mean() if chosen.any() else np.nan)
        rows.append((f"mean drag for t from {start:.4g} to {end:.4g}: {runs[0].name}, {other.name}, difference",
                     f"{means[0]:.5g}, {means[1]:.5g}, {100 * (means[1] / means[0] - 1):+.2f} %", True))
    return rows


def write_report(runs: list[CoupledRun], file: pathlib.Path) -> int:
    run = runs[0]
    report = Report(file.parent)
    report.parts.append(f"<h1>{html.escape(run.name)}</h1>")
    written = datetime.datetime.fromtimestamp((run.folder / "coupling.csv").stat().st_mtime)
    revision = run.root / "stages" / "revision"
    report.text(f"Coupled run, last written {written:%Y-%m-%d %H:%M}"
                + (f", Drogue at {revision.read_text().strip()}" if revision.exists() else "")
                + ". All values in the units of the case.")
    report.section("Figures")
    report.table(figures(run) + against_others(runs))
    if run.warnings():
        report.section("Warnings and errors")
        report.lines(run.warnings())

    report.section("Canopy and flow")
    report.picture("inflated", "The canopy before the coupled run, by its larger principal stress.",
                   lambda: report_pictures.inflated(run))
    report.picture("flow", "The last state: canopy by stress, flow and fluid mesh in the plane through the axis.",
                   lambda: report_pictures.last_state(run))
    report.picture("instants", "Fluid mesh and flow in a plane that stays where it is, and structure mesh, at four instants "
                   "0.63 apart, or equally spaced in a shorter run.", lambda: report_pictures.instants(run))

    report.section("Histories")
    report.picture("drag", "Drag of the canopy; broken: the weight of the system, where the structure has gravity.",
                   lambda: report_pictures.drag_of(runs))
    report.picture("spectrum", "Amplitudes of the drag over frequency, of its second half.",
                   lambda: report_pictures.spectrum(runs))
    report.picture("forces", "Forces that the structure reports: reactions of supports, net forces of line groups.",
                   lambda: report_pictures.structure_forces(runs))
    report.picture("velocities", "Velocities at the structure's probes (NAME_1, NAME_2, ...: their mean).",
                   lambda: report_pictures.probe_velocities(runs))
    report.picture("positions", "Displacement of the structure's probes.", lambda: report_pictures.probe_positions(runs))
    report.picture("impulse", "Change of the structure's vertical momentum, and impulse of all forces on it.",
                   lambda: report_pictures.impulse_balance(run))

    report.section("Coupling and cost")
    report.picture("residual", "Residual of every coupling iteration; iterations of every step.",
                   lambda: series_pictures.residual(run.folder))
    report.picture("time", "Wall-clock time by process.", lambda: report_pictures.time_by_process(run))
    if run.closing_lines():
        report.lines(run.closing_lines())

    report.section("Configs")
    for name, text in run.configs().items():
        report.details(name, text)
    report.write(file, run.name)
    print(f"    {file}", file=sys.stderr)
    return 0 if report.pictures else 1


def main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/report")
    parser.add_argument("runs", nargs="+", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path)
    arguments = parser.parse_args()
    plt.rcParams.update(SETTINGS)
    try:
        runs = [CoupledRun.find(folder) for folder in arguments.runs]
        return write_report(runs, arguments.output or runs[0].root / "report" / "report.html")
    except NothingToDraw as reason:
        print(f"error: {reason}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
