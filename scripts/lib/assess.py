#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Does a coupled parachute run hold together? assess.py RUN_DIR reads coupling.csv, drag.csv and the structure's series of
a coupled run, and prints a line a quantity, `VERIFY case quantity ours reference tolerance pass|FAIL`.
Exit status 1 if any fails, 2 if a file is missing.
"""
import csv
import pathlib
import sys

import numpy as np

import impulse

# The load takes the place of the inflation pressure within 0.1 s, some 32 steps; before that the drag says nothing.
STEPS_UNTIL_DRAG_COUNTS = 40


def read(file):
    with open(file, newline="") as stream:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(stream)]
    if not rows:
        sys.exit(f"{file} holds no rows")
    return rows


def mean(rows, name):
    return sum(row[name] for row in rows) / len(rows)


class Table:
    def __init__(self, case):
        self.case, self.passed = case, True

    def between(self, quantity, ours, lower, upper):
        passed = lower <= ours <= upper
        self.passed = self.passed and passed
        centre, width = 0.5 * (lower + upper), 0.5 * (upper - lower)
        print(f"VERIFY {self.case} {quantity} {ours:.6g} {centre:.6g} {width:.3g} {'pass' if passed else 'FAIL'}")


def judge_settled_drag(table, drag, structure, free):
    """Of the rows in which the drag has settled: against the weight of what falls freely, against its lines for what is held."""
    force = mean(drag, "force_z")
    if free:
        table.between("drag_over_weight", force / abs(mean(structure, "weight_z")), 0.4, 2)
    else:
        table.between("drag_coefficient", mean(drag, "cd"), 0.4, 1.2)
    if "reaction_confluence_z" in structure[0]:  # the lines hold what the air gives, up to the canopy's inertia
        table.between("line_force_over_drag", -mean(structure, "reaction_confluence_z") / force, 0.95, 1.05)


def main(run):
    try:
        coupling, drag = read(run / "coupling.csv"), read(run / "drag.csv")
        structure = read(run / "structure" / "structure.csv")
    except FileNotFoundError as missing:
        print(f"{missing.filename} is missing: is {run} the folder of a coupled run?", file=sys.stderr)
        return 2
    steps = len(drag)
    settled = slice(3 * steps // 4, None)
    judge_drag = steps >= STEPS_UNTIL_DRAG_COUNTS
    table = Table("t10/" + run.resolve().parent.name)
    print(f"{steps} steps, {mean(drag, 'iterations'):.2f} iterations a step on average")
    if not judge_drag:
        print(f"too few steps to judge the drag (from {STEPS_UNTIL_DRAG_COUNTS} on)")
    # The last iteration of what was committed; an attempt that was rolled back is followed by rows that end at its time.
    committed = {row["time"] for row in drag}
    last_rows = {row["time"]: row for row in coupling if row["time"] in committed}
    table.between("unconverged_steps", sum(row["converged"] != 1 for row in drag), 0, 0)
    table.between("largest_last_residual", max(row["residual_relative"] for row in last_rows.values()), 0, 1e-3)
    table.between("largest_force_defect", max(row["force_defect"] for row in coupling), 0, 1e-12)
    free = "reaction_confluence_z" not in structure[0] and mean(structure, "weight_z") != 0
    if judge_drag:
        judge_settled_drag(table, drag[settled], structure[-steps:][settled], free)
    if free:
        defect = impulse.largest_defect({name: np.array([row[name] for row in structure]) for name in structure[0]})
        table.between("largest_impulse_defect", np.nan if defect is None else defect, 0, 0.01)
    # The canopy breathes but stays inflated: the area it shows the wind, over the mean, and its change over the run.
    shown = [row["vector_area_z"] for row in drag]
    mean_shown = sum(shown) / steps
    table.between("smallest_projected_area", min(shown) / mean_shown, 0.5 if free else 0.8, 1)
    table.between("breathing_of_projected_area", (max(shown) - min(shown)) / mean_shown, 1e-4, 0.8 if free else 0.3)
    table.between("slack_cables", max(row["slack_fraction"] for row in structure[-steps:][settled]), 0, 0.05)
    table.between("smallest_volume_ratio", min(row["smallest_volume_ratio"] for row in coupling), 0.05, 2)
    return 0 if table.passed else 1


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(pathlib.Path(sys.argv[1])))
