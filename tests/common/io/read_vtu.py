# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the files that foreign_readers_test wrote with VTK and with meshio, and checks every value."""
import pathlib
import sys
import xml.etree.ElementTree

import meshio
import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

# Node counts and VTK cell types in the order the test writes its cells.
KINDS = [(27, vtk.VTK_TRIQUADRATIC_HEXAHEDRON), (10, vtk.VTK_QUADRATIC_TETRA), (4, vtk.VTK_TETRA), (3, vtk.VTK_TRIANGLE), (6, vtk.VTK_QUADRATIC_TRIANGLE), (4, vtk.VTK_QUAD),
         (9, vtk.VTK_BIQUADRATIC_QUAD), (2, vtk.VTK_LINE), (3, vtk.VTK_QUADRATIC_EDGE), (1, vtk.VTK_VERTEX)]


def points(count):
    return 0.1 * np.arange(3 * count, dtype=float).reshape(count, 3)


def read(file):
    problems = []
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.AddObserver("ErrorEvent", lambda *_: problems.append("error"))
    reader.SetFileName(str(file))
    reader.Update()
    assert not problems, f"VTK cannot read {file}"
    return reader.GetOutput()


def check_kinds(file):
    grid = read(file)
    assert np.array_equal(vtk_to_numpy(grid.GetPoints().GetData()), points(28))
    assert np.array_equal(vtk_to_numpy(grid.GetPointData().GetArray("velocity")), points(28))
    assert np.array_equal(vtk_to_numpy(grid.GetCellData().GetArray('cell <index> & "name"')), np.arange(10.0))
    assert grid.GetNumberOfCells() == len(KINDS)
    for index, (nodes, kind) in enumerate(KINDS):
        cell = grid.GetCell(index)
        assert cell.GetCellType() == kind
        assert [cell.GetPointId(a) for a in range(cell.GetNumberOfPoints())] == list(range(1, nodes + 1)) or nodes in (10, 27)
    mesh = meshio.read(file)
    assert np.array_equal(mesh.points, points(28))
    assert sorted(block.type for block in mesh.cells) == sorted(
        ["hexahedron27", "tetra10", "tetra", "triangle", "triangle6", "quad", "quad9", "line", "line3", "vertex"])


def check_parent(file, kind):
    cell = read(file).GetCell(0)
    assert cell.GetCellType() == kind
    nodes = [cell.GetPoints().GetPoint(a) for a in range(cell.GetNumberOfPoints())]
    assert np.array_equal(np.ravel(nodes), [cell.GetParametricCoords()[i] for i in range(3 * len(nodes))])


def check_large(file):
    count = 65536
    grid = read(file)
    assert np.array_equal(vtk_to_numpy(grid.GetPoints().GetData()), points(count))
    assert np.array_equal(vtk_to_numpy(grid.GetPointData().GetArray("whole_blocks")), points(count).ravel()[:count])
    assert grid.GetNumberOfCells() == count
    assert np.array_equal(meshio.read(file).points, points(count))


def check_collection(file):
    entries = [dict(entry.attrib) for entry in xml.etree.ElementTree.parse(file).iter("DataSet")]
    assert [float(entry["timestep"]) for entry in entries] == [0.25, 0.5]
    assert [entry["file"] for entry in entries] == ["kinds.vtu", "large.vtu"]


folder = pathlib.Path(sys.argv[1])
check_kinds(folder / "kinds.vtu")
check_parent(folder / "parent_10.vtu", vtk.VTK_QUADRATIC_TETRA)
check_parent(folder / "parent_27.vtu", vtk.VTK_TRIQUADRATIC_HEXAHEDRON)
check_large(folder / "large.vtu")
assert read(folder / "empty.vtu").GetNumberOfCells() == 0
check_collection(folder / "all.pvd")
