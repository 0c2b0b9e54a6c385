#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh mover of the oscillator tests in Python: 7 x 7 squares on the unit square, every node moves with the wall."""

import sys

import numpy as np

from drogue.participant import Description, InterfaceMesh, Report, Solver, field_contract, main

CELLS = 7


class SurfaceMover(Solver):
    def describe(self):
        return Description(
            software="surface_mover.py",
            inputs=[field_contract("displacement", "DISPLACEMENT", "INTERFACE_NODES", 3)],
            outputs=[field_contract("mesh_displacement", "DISPLACEMENT", "MESH_NODES", 3)],
        )

    def initialize(self):
        row = CELLS + 1
        y, x = np.divmod(np.arange(row * row), row)
        a = (np.arange(CELLS)[:, None] * row + np.arange(CELLS)).ravel()
        return InterfaceMesh(
            points=np.column_stack([x / CELLS, y / CELLS, 0 * x]),
            triangles=np.concatenate([np.column_stack([a, a + 1, a + row + 1]), np.column_stack([a, a + row + 1, a + row])]),
            mesh_nodes=np.arange(row * row),
            mesh_node_count=row * row,
        )

    def iterate(self, inputs):
        return {"mesh_displacement": inputs["displacement"]}, Report()


sys.exit(main(SurfaceMover(), sys.argv[sys.argv.index("--connect") + 1]))
