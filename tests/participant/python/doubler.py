# SPDX-License-Identifier: GPL-3.0-or-later
"""A participant for the test: doubles the force it gets. Its first value steers what goes wrong."""

import sys
import time

import numpy as np

from drogue.participant import (
    Description,
    InterfaceMesh,
    ReplacedMesh,
    Report,
    Solver,
    SolverError,
    field_contract,
    main,
    report_progress,
)


class Doubler(Solver):
    iterations = 0

    def describe(self):
        return Description(
            software="doubler.py",
            can_replace_mesh=True,
            inputs=[field_contract("force", "FORCE", "INTERFACE_NODES", 3)],
            outputs=[field_contract("displacement", "DISPLACEMENT", "INTERFACE_NODES", 3)],
        )

    def initialize(self):
        points = np.array([[0, 0, 0], [1, 0, 0]])
        return InterfaceMesh(points=points, lines=np.array([[1, 0]]), mesh_node_count=2, mesh_hash="abc")

    def new_mesh(self):
        return ("/tmp/new.msh", "def", "worn") if self.iterations == 1 else None

    def replace_mesh(self, file, mesh_hash, restoring):
        return ReplacedMesh(mesh_nodes=[8 if restoring else 7, 9], mesh_node_count=10, mesh_hash=mesh_hash, momentum_defect=0.2)

    def iterate(self, inputs):
        self.iterations += 1
        force = inputs["force"]
        if force[0, 0] == 1:
            raise SolverError("too much force", retryable=True)
        if force[0, 0] == 2:
            return {"displacement": force * np.nan}, Report()
        if force[0, 0] == 3:
            report_progress("sleeping", 7, 0.25)
            time.sleep(1.8)
        if force[0, 0] == 6:
            report_progress(6)  # not a text: the beat cannot be made
            time.sleep(1.8)
        if force[0, 0] == 4:
            raise ValueError("a bug")
        if force[0, 0] == 5:
            return {"displacement": np.zeros((5, 3))}, Report()
        return {"displacement": 2 * force}, Report(self.iterations, 0.5, True)


sys.exit(main(Doubler(), sys.argv[1]))
