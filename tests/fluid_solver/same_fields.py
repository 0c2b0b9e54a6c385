# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads two field files, .vtu or .pvtu, with VTK: the same cells with the same values at their corners, in any order."""
import pathlib
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy


def read(file):
    problems = []
    parallel = pathlib.Path(file).suffix == ".pvtu"
    reader = vtk.vtkXMLPUnstructuredGridReader() if parallel else vtk.vtkXMLUnstructuredGridReader()
    reader.AddObserver("ErrorEvent", lambda *_: problems.append("error"))
    reader.SetFileName(file)
    reader.Update()
    assert not problems, f"VTK cannot read {file}"
    return reader.GetOutput()


def cells(file):
    """Per cell its mean position and the mean of every array at its corners, sorted by position."""
    grid = read(file)
    corners = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(grid.GetNumberOfCells(), -1)
    data = grid.GetPointData()
    names = sorted(data.GetArrayName(i) for i in range(data.GetNumberOfArrays()))
    columns = [vtk_to_numpy(grid.GetPoints().GetData())] + [vtk_to_numpy(data.GetArray(name)) for name in names]
    values = np.column_stack([column.reshape(len(column), -1)[corners].mean(axis=1) for column in columns])
    return names, values[np.lexsort(values[:, :3].round(9).T)]


(names, one), (others, many) = cells(sys.argv[1]), cells(sys.argv[2])
assert names == others and one.shape == many.shape, (names, others, one.shape, many.shape)
assert "velocity" in names and len(one) > 0
assert np.allclose(one, many, rtol=0, atol=1e-6 * np.abs(one).max()), np.abs(one - many).max()
