#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh mover in Python that takes the place of Drogue's own: inverse-distance weighting.

The displacement of a node is the mean of its nearest boundary nodes' displacements, weighted with distance^-POWER.
Interface nodes follow the coupler; the other boundaries follow the outer translation. The weights are computed once,
on the initial mesh, so that a closed cycle of the boundary returns the initial mesh.

    mesh_mover.py --mesh fluid.msh --interface canopy_upper canopy_lower --connect ENDPOINT
    in case.textproto:  mesh_mover { command: "mesh_mover.py" argument: "--mesh" argument: "${config_dir}/fluid.msh" ... }
"""

import argparse
import os
import sys

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree

from drogue.participant import Description, Error, InterfaceMesh, Report, Solver, SolverError, field_contract, main
from fluid_mesh import FluidMesh

NEIGHBOURS = 32
POWER = 3
TETRAHEDRON = 4


class InverseDistance(Solver):
    def __init__(self, mesh_file, interface):
        self.mesh_file, self.interface = mesh_file, interface

    def describe(self):
        return Description(
            software="python_mesh_mover",
            can_checkpoint=True,
            inputs=[
                field_contract("displacement", "DISPLACEMENT", "INTERFACE_NODES", 3),
                field_contract("translation", "TRANSLATION", "GLOBAL", 3),
            ],
            outputs=[
                field_contract("mesh_displacement", "DISPLACEMENT", "MESH_NODES", 3),
                field_contract("quality", "QUALITY", "GLOBAL", 3),
            ],
        )

    def initialize(self):
        if not os.path.isfile(self.mesh_file):
            raise SolverError(f"{self.mesh_file}: there is no such file", Error.CONFIGURATION)
        mesh = self.mesh = FluidMesh(self.mesh_file)
        unknown = set(self.interface) - set(mesh.groups())
        if unknown:
            raise SolverError(
                f"{self.mesh_file} has no boundary {sorted(unknown)}; there are {mesh.groups()}", Error.CONFIGURATION
            )
        self.wall = mesh.nodes(self.interface)
        outer = mesh.nodes(set(mesh.groups()) - set(self.interface))
        self.outer = np.setdiff1d(outer, self.wall)
        self.tets = np.concatenate([nodes for _, kind, nodes in mesh.blocks if kind == TETRAHEDRON])
        self.initial_volumes = self.volumes(mesh.points)
        self.weights = self.inverse_distance_weights()
        material = None if mesh.material is None else mesh.material[self.wall]
        return InterfaceMesh(
            points=mesh.points[self.wall],
            triangles=np.searchsorted(self.wall, mesh.triangles(self.interface)),
            material=material if material is not None and np.isfinite(material).all() else None,
            mesh_nodes=self.wall,
            mesh_node_count=len(mesh.points),
            mesh_hash=mesh.hash(),
        )

    def iterate(self, inputs):
        boundary = np.concatenate([inputs["displacement"], np.repeat(inputs["translation"], len(self.outer), axis=0)])
        displacement = self.weights @ boundary
        moved = self.mesh.points + displacement
        ratio = self.volumes(moved) / self.initial_volumes
        if ratio.min() <= 0:
            worst = int(ratio.argmin())
            place = moved[self.tets[worst]].mean(axis=0).round(4).tolist()
            raise SolverError(f"tetrahedron {worst} at {place} is inverted; try a smaller step", retryable=True)
        shape = self.mean_ratios(moved)
        quality = np.array([[ratio.min(), shape.min(), shape.mean()]])
        return {"mesh_displacement": displacement, "quality": quality}, Report()

    # The answer depends on the inputs alone: there is no state to save, roll back or restore.

    def inverse_distance_weights(self):
        """Sparse matrix {nodes, boundary nodes} from boundary displacements to all nodes."""
        points, boundary = self.mesh.points, np.concatenate([self.wall, self.outer])
        count = min(NEIGHBOURS, len(boundary))
        # The nearest of the wall and of the outer boundary both take part, or nothing would fade out between them.
        columns, distances, start = [], [], 0
        for nodes in (self.wall, self.outer):
            if len(nodes):
                distance, nearest = cKDTree(points[nodes]).query(points, k=min(count, len(nodes)))
                distances.append(distance.reshape(len(points), -1))
                columns.append(nearest.reshape(len(points), -1) + start)
            start += len(nodes)
        columns, distances = np.hstack(columns), np.hstack(distances)
        values = np.maximum(distances, 1e-30) ** -float(POWER)
        values /= values.sum(axis=1, keepdims=True)
        rows = np.repeat(np.arange(len(points)), columns.shape[1])
        weights = csr_matrix((values.ravel(), (rows, columns.ravel())), shape=(len(points), len(boundary)))
        keep = np.ones(len(points))
        keep[boundary] = 0  # boundary nodes follow their own value exactly
        own = csr_matrix((np.ones(len(boundary)), (boundary, np.arange(len(boundary)))), shape=weights.shape)
        return weights.multiply(keep[:, None]).tocsr() + own

    def volumes(self, points):
        x = points[self.tets]
        return np.einsum("ij,ij->i", x[:, 1] - x[:, 0], np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 0])) / 6

    def mean_ratios(self, points):
        x = points[self.tets]
        edges = sum(((x[:, a] - x[:, b]) ** 2).sum(axis=1) for a in range(4) for b in range(a))
        return 12 * np.cbrt(3 * np.maximum(self.volumes(points), 0)) ** 2 / edges


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="mesh mover by inverse-distance weighting")
    parser.add_argument("--mesh", required=True, help="fluid mesh (.msh)")
    parser.add_argument("--interface", required=True, nargs="+", help="boundaries that follow the structure")
    parser.add_argument("--connect", required=True, help="where the coupler listens; the coupler adds this")
    arguments = parser.parse_args()
    sys.exit(main(InverseDistance(arguments.mesh, arguments.interface), arguments.connect))
