# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of a run: pictures.py RUN_DIR OUTPUT_DIR (called by scripts/picture on a virtual screen)."""
import pathlib
import sys

import matplotlib.pyplot as plt

import field_pictures
import series_pictures
from result_files import NothingToDraw

SETTINGS = {"font.size": 11, "axes.grid": True, "grid.alpha": 0.3, "axes.spines.top": False, "axes.spines.right": False,
            "figure.dpi": 120, "savefig.bbox": "tight"}


def main() -> int:
    run, output = map(pathlib.Path, sys.argv[1:3])
    plt.rcParams.update(SETTINGS)
    output.mkdir(parents=True, exist_ok=True)
    drawn = 0
    for name, draw in (("canopy", field_pictures.canopy), ("drag", series_pictures.drag),
                       ("residual", series_pictures.residual)):
        try:
            figure = draw(run)
        except NothingToDraw as reason:
            print(f"    {name}.png left out: {reason}", file=sys.stderr)
            continue
        file = output / f"{name}.png"
        figure.savefig(file)
        plt.close(figure)
        print(f"    {file}", file=sys.stderr)
        drawn += 1
    return 0 if drawn else 1


if __name__ == "__main__":
    sys.exit(main())
