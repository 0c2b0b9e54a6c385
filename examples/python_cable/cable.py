#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A structure in Python that takes the place of Drogue's own: a taut cable between two fixed points.

Two-node elements in total Lagrangian form: with l the vector from end to end, L its reference length, e the Green strain
(|l|^2 - L^2) / (2 L^2), T the tension in the reference and EA the stiffness, the force at the ends is +-(T + EA e) l / L.
Lumped mass; generalised-alpha in time [chung1993], Newton's method in each step.

    cable.py --from 0 0.5 --to 1 0.5 --elements 20 --line-density 0.03 --tension 1 --stiffness 0.01 --free y
             --start 0.001 --connect ENDPOINT

The cable lies in the plane z = 0 and moves in the directions that are free. It starts at rest, displaced along the last of
them by a sine of the amplitude --start.
"""

import argparse
import os
import sys

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import spsolve

from drogue.participant import Description, InterfaceMesh, Report, Solver, SolverError, field_contract, main

MOST_ITERATIONS = 30
STATE = ("u", "v", "a", "force")


class Cable(Solver):
    def __init__(self, options):
        n = options.elements
        s = np.linspace(0, 1, n + 1)[:, None]
        start, end = np.array(options.start_point + [0.0]), np.array(options.end_point + [0.0])
        self.reference = start + s * (end - start)
        self.ends = np.column_stack([np.arange(n), np.arange(1, n + 1)])
        self.length = np.linalg.norm(end - start) / n
        self.tension, self.stiffness = options.tension, options.stiffness
        self.tolerance = options.tolerance
        mass = np.full(n + 1, options.line_density * self.length)
        mass[[0, -1]] /= 2
        self.mass = np.repeat(mass, 3)
        axes = ["xyz".index(axis) for axis in options.free]
        self.free = (3 * np.arange(1, n)[:, None] + axes).ravel()
        self.u = np.zeros((n + 1, 3))
        self.u[:, axes[-1]] = options.start * np.sin(np.pi * s[:, 0])
        self.u[[0, -1]] = 0
        self.start = self.u.copy()
        self.v, self.a = np.zeros_like(self.u), np.zeros_like(self.u)
        self.force = None  # of the fluid at t_n
        rho = options.rho_infinity
        self.alpha_m, self.alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
        self.gamma = 0.5 - self.alpha_m + self.alpha_f
        self.beta = 0.25 * (1 - self.alpha_m + self.alpha_f) ** 2

    def describe(self):
        return Description(
            software="python_cable",
            can_checkpoint=True,
            inputs=[field_contract("force", "FORCE", "INTERFACE_NODES", 3)],
            outputs=[
                field_contract("displacement", "DISPLACEMENT", "INTERFACE_NODES", 3),
                field_contract("velocity", "VELOCITY", "INTERFACE_NODES", 3),
            ],
        )

    def initialize(self):
        nodes = len(self.reference)
        return InterfaceMesh(
            points=self.reference + self.u, reference=self.reference, lines=self.ends, mesh_node_count=nodes
        )

    def begin_step(self, step, attempt, time, time_step):
        self.dt = time_step
        self.next = {"u": self.u + time_step * self.v, "v": self.v, "a": self.a, "force": None}

    def iterate(self, inputs):
        dt, beta, gamma, am, af = self.dt, self.beta, self.gamma, self.alpha_m, self.alpha_f
        force = inputs["force"]
        load = force if self.force is None else (1 - af) * force + af * self.force
        u = self.next["u"].copy()
        for iteration in range(1, MOST_ITERATIONS + 1):
            a = (u - self.u - dt * self.v) / (beta * dt**2) - (0.5 / beta - 1) * self.a
            inner, tangent = self.internal((1 - af) * u + af * self.u)
            residual = self.mass * ((1 - am) * a + am * self.a).ravel() + inner - load.ravel()
            matrix = (1 - af) * tangent + diags((1 - am) / (beta * dt**2) * self.mass)
            correction = spsolve(matrix.tocsc()[self.free][:, self.free], -residual[self.free])
            if not np.isfinite(correction).all():
                raise SolverError("the cable's tangent is singular; try a smaller step", retryable=True)
            u.ravel()[self.free] += correction
            if np.abs(correction).max() <= self.tolerance:
                break
        else:
            raise SolverError(f"the cable did not converge in {MOST_ITERATIONS} iterations", retryable=True)
        a = (u - self.u - dt * self.v) / (beta * dt**2) - (0.5 / beta - 1) * self.a
        v = self.v + dt * ((1 - gamma) * self.a + gamma * a)
        self.next = {"u": u, "v": v, "a": a, "force": force.copy()}
        return {"displacement": u - self.start, "velocity": v}, Report(iteration)

    def internal(self, u):
        """Nodal forces {3 n} and their derivative, of a displacement {n, 3}."""
        x = self.reference + u
        l = x[self.ends[:, 1]] - x[self.ends[:, 0]]
        strain = ((l**2).sum(axis=1) - self.length**2) / (2 * self.length**2)
        pull = (self.tension + self.stiffness * strain) / self.length
        forces = np.zeros_like(u)
        np.add.at(forces, self.ends[:, 1], pull[:, None] * l)
        np.add.at(forces, self.ends[:, 0], -pull[:, None] * l)
        block = pull[:, None, None] * np.eye(3) + self.stiffness / self.length**3 * l[:, :, None] * l[:, None, :]
        blocks = np.block([[block, -block], [-block, block]])
        equations = (3 * self.ends[:, :, None] + np.arange(3)).reshape(len(l), 6)
        rows, columns = np.repeat(equations, 6, axis=1).ravel(), np.tile(equations, 6).ravel()
        return forces.ravel(), csr_matrix((blocks.ravel(), (rows, columns)), shape=(u.size, u.size))

    def commit(self, write_output):
        for name in STATE:
            setattr(self, name, self.next[name])

    def checkpoint(self, directory):
        state = {name: getattr(self, name) for name in STATE if getattr(self, name) is not None}
        np.savez(os.path.join(directory, "cable.npz"), **state)

    def restore(self, directory):
        with np.load(os.path.join(directory, "cable.npz")) as state:
            for name in STATE:
                setattr(self, name, state[name] if name in state else None)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="a taut cable between two fixed points")
    parser.add_argument("--from", dest="start_point", nargs=2, type=float, required=True, help="x y of one end")
    parser.add_argument("--to", dest="end_point", nargs=2, type=float, required=True, help="x y of the other")
    parser.add_argument("--elements", type=int, default=20)
    parser.add_argument("--line-density", type=float, required=True, help="mass per length")
    parser.add_argument("--tension", type=float, required=True, help="in the reference configuration")
    parser.add_argument("--stiffness", type=float, required=True, help="EA")
    parser.add_argument("--free", default="xy", help="directions in which it moves")
    parser.add_argument("--start", type=float, default=0, help="amplitude of the sine it starts from")
    parser.add_argument("--rho-infinity", type=float, default=0.9, help="spectral radius at infinite frequency")
    parser.add_argument("--tolerance", type=float, default=1e-12, help="largest correction of the last iteration [length]")
    parser.add_argument("--connect", required=True, help="where the coupler listens; the coupler adds this")
    arguments = parser.parse_args()
    sys.exit(main(Cable(arguments), arguments.connect))
