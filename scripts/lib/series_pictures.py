# SPDX-License-Identifier: GPL-3.0-or-later
"""Time histories of a coupled run: drag and coupling residuals. Values are in the units of the case."""
import pathlib

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MaxNLocator

from result_files import read_series


def drag(run: pathlib.Path):
    """The force of the fluid on the canopy, and the drag coefficient where the case defines one."""
    data = read_series(run, "drag.csv", ["time", "force_x", "force_y", "force_z"])
    with_coefficient = "cd" in data and np.isfinite(data["cd"]).any()
    figure, axes = plt.subplots(2 if with_coefficient else 1, 1, figsize=(8, 6.4 if with_coefficient else 3.6),
                                sharex=True, squeeze=False)
    for component, colour in (("x", "tab:orange"), ("y", "tab:green"), ("z", "tab:blue")):
        axes[0, 0].plot(data["time"], data[f"force_{component}"], color=colour, label=f"$F_{component}$", lw=1.6)
    axes[0, 0].set_ylabel("force on the canopy\n(unit of the case)")
    axes[0, 0].legend(frameon=False, ncol=3)
    if with_coefficient:
        axes[1, 0].plot(data["time"], data["cd"], color="tab:blue", lw=1.6)
        axes[1, 0].set_ylabel("drag coefficient")
    axes[-1, 0].set_xlabel("time (unit of the case)")
    figure.align_ylabels()
    figure.suptitle("Drag of the canopy")
    figure.tight_layout()
    return figure


def residual(run: pathlib.Path):
    """The coupling residual of every iteration, step after step, and the number of iterations of every step."""
    data = read_series(run, "coupling.csv", ["step", "iteration", "residual_relative"])
    steps = np.unique(data["step"])
    figure, (above, below) = plt.subplots(2, 1, figsize=(8, 6.4), gridspec_kw={"height_ratios": [2, 1]})
    count = np.arange(1, len(data["step"]) + 1)
    for index, step in enumerate(steps):
        mine = data["step"] == step
        above.semilogy(count[mine], data["residual_relative"][mine], ".-", ms=4, lw=1,
                       color=("tab:blue", "tab:orange")[index % 2])
    above.set_xlabel("coupling iteration, counted over the run (the colour changes with the step)")
    above.set_ylabel("relative residual")
    below.bar(steps, [np.sum(data["step"] == step) for step in steps], width=0.85, color="tab:blue")
    below.set_axisbelow(True)
    below.set_xlabel("step")
    below.set_ylabel("iterations")
    below.xaxis.set_major_locator(MaxNLocator(integer=True))
    below.yaxis.set_major_locator(MaxNLocator(integer=True))
    figure.suptitle("Convergence of the coupling iteration")
    figure.tight_layout()
    return figure
