# SPDX-License-Identifier: GPL-3.0-or-later
"""Newton's second law over a run: the structure's change of momentum against the impulse of all forces on it."""
import numpy as np

GIVEN = ("momentum_z", "external_force_z", "interface_force_z")


def vertical_balance(series: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Of the columns of structure.csv: {steps} change of the vertical momentum since the first row, {steps} impulse since
    then of loads, fluid and supports by the trapezoidal rule, and the size that a difference is to be compared with: the
    impulse of the weight, or of all forces' magnitudes where nothing weighs. Nothing for a series without these columns or
    with a single row."""
    if any(name not in series for name in GIVEN) or len(series["time"]) < 2:
        return None
    reactions = [name for name in series if name.startswith("reaction_") and name.endswith("_z")]
    forces = [series[name] for name in ("external_force_z", "interface_force_z", *reactions)]
    steps = np.diff(series["time"])

    def integral(force):
        return np.concatenate(([0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * steps)))

    weight = integral(np.abs(series["weight_z"]))[-1] if "weight_z" in series else 0.0
    size = weight or integral(sum(np.abs(force) for force in forces))[-1]
    return series["momentum_z"] - series["momentum_z"][0], integral(sum(forces)), float(size)


def largest_defect(series: dict[str, np.ndarray]) -> float | None:
    balance = vertical_balance(series)
    if balance is None or balance[2] == 0:
        return None
    change, impulse, size = balance
    return float(np.abs(change - impulse).max() / size)
