# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds and reads the result files of a run folder."""
import csv
import pathlib

import numpy as np
import vtk


class NothingToDraw(Exception):
    """The data of a picture are missing; the text says which."""


def latest(run: pathlib.Path, pattern: str) -> pathlib.Path:
    """The last file in order of names in the folder that was written last; stages have a folder each."""
    files = sorted(run.rglob(pattern))
    if not files:
        raise NothingToDraw(f"no {pattern} below {run}")
    folder = max(files, key=lambda file: file.stat().st_mtime).parent
    return [file for file in files if file.parent == folder][-1]


def read_vtu(file: pathlib.Path) -> vtk.vtkUnstructuredGrid:
    """Of a .vtu, or of a .pvtu with its pieces."""
    problems = []
    parallel = file.suffix == ".pvtu"
    reader = vtk.vtkXMLPUnstructuredGridReader() if parallel else vtk.vtkXMLUnstructuredGridReader()
    reader.AddObserver("ErrorEvent", lambda *_: problems.append(True))
    reader.SetFileName(str(file))
    reader.Update()
    grid = reader.GetOutput()
    if problems or grid.GetNumberOfCells() == 0:
        raise NothingToDraw(f"{file} cannot be read")
    return grid


def read_series(run: pathlib.Path, name: str, columns: list[str]) -> dict[str, np.ndarray]:
    file = latest(run, name)
    with file.open() as stream:
        rows = list(csv.DictReader(stream))
    missing = [column for column in columns if not rows or column not in rows[0]]
    if not rows or missing:
        raise NothingToDraw(f"{file} has no rows" if not rows else f"{file} has no column {', '.join(missing)}")
    # The last row of a run that is still going on may be incomplete.
    complete = [row for row in rows if all(value not in (None, "") for value in row.values())]
    return {column: np.array([float(row[column]) for row in complete]) for column in complete[0]}
