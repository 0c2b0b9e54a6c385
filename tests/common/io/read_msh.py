# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the mesh that foreign_readers_test wrote with meshio and checks every value."""
import sys

import meshio
import numpy as np

NODES = {"tetra": 4, "triangle": 3, "triangle6": 6, "quad": 4, "quad9": 9, "line": 2, "line3": 3, "vertex": 1}
# meshio has its own node order for these.
VOLUMES = {"tetra10": 10, "hexahedron27": 27}

mesh = meshio.read(sys.argv[1])
expected = 0.1 * np.arange(84, dtype=float).reshape(28, 3)
assert np.array_equal(mesh.points, expected)
assert np.array_equal(mesh.point_data["field"], expected)
assert {block.type: block.data.tolist() for block in mesh.cells if block.type not in VOLUMES} == {
    kind: [list(range(1, nodes + 1))] for kind, nodes in NODES.items()}
assert {block.type: sorted(block.data.ravel()) for block in mesh.cells if block.type in VOLUMES} == {
    kind: list(range(1, nodes + 1)) for kind, nodes in VOLUMES.items()}
assert len(mesh.field_data) == 10, mesh.field_data
assert sorted(mesh.field_data)[0] == "group 1/0"
