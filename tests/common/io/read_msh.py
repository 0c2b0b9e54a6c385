# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the mesh that foreign_readers_test wrote with meshio and checks every value."""
import sys

import meshio
import numpy as np

NODES = {"tetra": 4, "triangle": 3, "triangle6": 6, "quad": 4, "quad9": 9, "line": 2, "line3": 3, "vertex": 1}

mesh = meshio.read(sys.argv[1])
expected = 0.1 * np.arange(30, dtype=float).reshape(10, 3)
assert np.array_equal(mesh.points, expected)
assert np.array_equal(mesh.point_data["field"], expected)
assert {block.type: block.data.tolist() for block in mesh.cells} == {
    kind: [list(range(1, nodes + 1))] for kind, nodes in NODES.items()}
assert len(mesh.field_data) == 8, mesh.field_data
assert sorted(mesh.field_data)[0] == "group 1/0"
