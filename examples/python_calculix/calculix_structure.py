#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""CalculiX as the structure: an adapter that drives the program ccx, which knows nothing of Drogue, by its own input decks.

The user's deck holds the model, everything before the first *STEP: nodes, elements (C3D8, C3D4), materials, *BOUNDARY, and
the wet faces as `*SURFACE, NAME=..., TYPE=ELEMENT`. Every iterate is a run of ccx over one increment of the step:

    *RESTART, READ        the state at t_n, which the run of the last committed iterate wrote
    *DYNAMIC, DIRECT      HHT-alpha [hilber1977]
    *CLOAD                the fluid's nodal forces, linear in time from those at t_n to those at t_{n+1}
    *NODE PRINT           U and V of the wet nodes: the answer
    *RESTART, WRITE

    calculix_structure.py --deck bar.inp --surface WET --connect ENDPOINT

ccx prints seven digits: a coupling tolerance below 1e-6 of the displacement cannot be met.
"""

import argparse
import os
import shutil
import subprocess
import sys

import numpy as np

from drogue.participant import Description, Error, InterfaceMesh, Report, Solver, SolverError, field_contract, main

# Corners of the faces of an element, in CalculiX's numbering.
FACES = {
    "C3D8": [(1, 2, 3, 4), (5, 8, 7, 6), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 8, 4), (4, 8, 5, 1)],
    "C3D4": [(1, 2, 3), (1, 4, 2), (2, 4, 3), (3, 4, 1)],
}
JOB = "iterate"
NUMBER = "{:.11e}"  # ccx reads twenty characters
SHOWN_LINES = 5


class Deck:
    """What the adapter needs to know of a model: the text, the nodes, and the faces of a surface."""

    def __init__(self, file, surface):
        try:
            with open(file, encoding="utf-8") as stream:
                self.text = stream.read()
        except OSError as error:
            raise SolverError(f"cannot read {file}: {error.strerror}", Error.CONFIGURATION) from error
        self.nodes, self.elements, self.faces = {}, {}, []
        for keyword, options, rows in self.blocks():
            if keyword == "*STEP":
                raise SolverError(f"{file} has a *STEP: the adapter writes the steps itself", Error.CONFIGURATION)
            if keyword == "*NODE":
                self.nodes.update((int(row[0]), [float(x) for x in row[1:4]]) for row in rows)
            if keyword == "*ELEMENT":
                self.elements.update((int(row[0]), (options.get("TYPE"), [int(n) for n in row[1:]])) for row in rows)
            if keyword == "*SURFACE" and options.get("NAME") == surface.upper():
                self.faces += [(int(row[0]), int(row[1].upper().lstrip("S"))) for row in rows]
        if not self.faces:
            raise SolverError(f"{file} has no *SURFACE, NAME={surface}, TYPE=ELEMENT", Error.CONFIGURATION)

    def blocks(self):
        """Keyword, its options, and its data lines, of every card."""
        keyword, options, rows = "", {}, []
        for line in self.text.splitlines() + ["*"]:
            if line.startswith("**") or not line.strip():
                continue
            if not line.startswith("*"):
                rows.append([word.strip() for word in line.strip().rstrip(",").split(",")])
                continue
            if keyword:
                yield keyword, options, rows
            words = [word.strip().upper() for word in line.split(",")]
            keyword, rows = words[0], []
            options = dict(word.partition("=")[::2] for word in words[1:])

    def corners(self):
        """Nodes of every wet face."""
        for element, face in self.faces:
            kind, nodes = self.elements[element]
            if kind not in FACES:
                raise SolverError(f"wet elements of type {kind} are not known: {list(FACES)}", Error.CONFIGURATION)
            yield [nodes[corner - 1] for corner in FACES[kind][face - 1]]


class CalculixStructure(Solver):
    def __init__(self, program, deck_file, surface, alpha):
        self.program, self.alpha = program, alpha
        self.deck_file, self.surface = os.path.abspath(deck_file), surface

    def describe(self):
        return Description(
            software="CalculiX",
            can_checkpoint=True,
            inputs=[field_contract("force", "FORCE", "INTERFACE_NODES", 3)],
            outputs=[
                field_contract("displacement", "DISPLACEMENT", "INTERFACE_NODES", 3),
                field_contract("velocity", "VELOCITY", "INTERFACE_NODES", 3),
            ],
        )

    def configure(self, directory, start_time, time_step):
        self.directory = directory

    def initialize(self):
        self.deck = Deck(self.deck_file, self.surface)
        corners = list(self.deck.corners())
        self.wet = sorted({node for face in corners for node in face})
        index = {node: i for i, node in enumerate(self.wet)}
        by_size = {size: [[index[n] for n in face] for face in corners if len(face) == size] for size in (3, 4)}
        self.steps = 0  # committed
        self.force = None  # at t_n
        return InterfaceMesh(
            points=np.array([self.deck.nodes[node] for node in self.wet]),
            triangles=np.array(by_size[3]) if by_size[3] else None,
            quadrangles4=np.array(by_size[4]) if by_size[4] else None,
            mesh_node_count=len(self.deck.nodes),
        )

    def begin_step(self, step, attempt, time, time_step):
        self.dt = time_step

    def iterate(self, inputs):
        self.new_force = inputs["force"].copy()
        if self.steps:
            shutil.copyfile(self.path("state.rin"), self.path(JOB + ".rin"))
        for old in ("dat", "rout"):
            if os.path.exists(self.path(f"{JOB}.{old}")):
                os.remove(self.path(f"{JOB}.{old}"))
        with open(self.path(JOB + ".inp"), "w", encoding="utf-8") as stream:
            stream.write(self.step_text())
        run = subprocess.run(
            [self.program, "-i", JOB], cwd=self.directory, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            env={**os.environ, "OMP_NUM_THREADS": "1"}, check=False,
        )
        if run.returncode or not os.path.exists(self.path(JOB + ".rout")):
            lines = [line.strip() for line in run.stdout.splitlines() if line.strip()]
            raise SolverError("ccx failed: " + " | ".join(lines[-SHOWN_LINES:]), retryable=True)
        displacement, velocity = self.printed()
        return {"displacement": displacement, "velocity": velocity}, Report()

    def step_text(self):
        """One step of one increment; the first one with the model."""
        before = self.new_force if self.force is None else self.force
        number = NUMBER.format
        dt = number(self.dt)
        lines = [f"*RESTART,READ,STEP={self.steps}"] if self.steps else [self.deck.text.rstrip()]
        lines += ["*NSET,NSET=DROGUE_WET", *map(str, self.wet)] if not self.steps else []
        loads = []
        for node, old, new in zip(self.wet, before, self.new_force):
            for c in range(3):
                if old[c] == 0 and new[c] == 0:
                    continue
                name = f"S{self.steps}N{node}C{c + 1}"  # an amplitude of an earlier step would be found first
                lines += [f"*AMPLITUDE,NAME={name}", f"0.,{number(old[c])},{dt},{number(new[c])}"]
                loads += [f"*CLOAD{',OP=NEW' if not loads else ''},AMPLITUDE={name}", f"{node},{c + 1},1."]
        lines += ["*STEP,INC=1,NLGEOM", f"*DYNAMIC,DIRECT,ALPHA={self.alpha}", f"{dt},{dt}"]
        lines += ["*RESTART,WRITE,FREQUENCY=1", *(loads or ["*CLOAD,OP=NEW"])]
        lines += ["*NODE PRINT,NSET=DROGUE_WET,FREQUENCY=1", "U,V", "*END STEP", ""]
        return "\n".join(lines)

    def printed(self):
        """Displacement and velocity of the wet nodes, from the tables of the .dat file."""
        tables = []
        with open(self.path(JOB + ".dat"), encoding="utf-8") as stream:
            for line in stream:
                words = line.split()
                if "for set DROGUE_WET" in line:
                    tables.append({})
                elif tables and len(words) == 4:
                    tables[-1][int(words[0])] = [float(word) for word in words[1:]]
        if len(tables) != 2 or any(set(table) != set(self.wet) for table in tables):
            raise SolverError("ccx printed no displacement and velocity for every wet node", Error.INTERNAL)
        return [np.array([table[node] for node in self.wet]) for table in tables]

    def commit(self, write_output):
        os.replace(self.path(JOB + ".rout"), self.path("state.rin"))
        self.steps += 1
        self.force = self.new_force

    def checkpoint(self, directory):
        np.savez(os.path.join(directory, "adapter.npz"), steps=self.steps, force=[] if self.force is None else self.force)
        if self.steps:
            shutil.copyfile(self.path("state.rin"), os.path.join(directory, "state.rin"))

    def restore(self, directory):
        with np.load(os.path.join(directory, "adapter.npz")) as state:
            self.steps = int(state["steps"])
            self.force = state["force"] if self.steps else None
        if self.steps:
            shutil.copyfile(os.path.join(directory, "state.rin"), self.path("state.rin"))

    def path(self, name):
        return os.path.join(self.directory, name)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="CalculiX as a structure")
    parser.add_argument("--deck", required=True, help="the model: an input deck without steps")
    parser.add_argument("--surface", required=True, help="name of the *SURFACE that the fluid wets")
    parser.add_argument("--program", default="ccx", help="Debian: package calculix-ccx")
    parser.add_argument("--alpha", type=float, default=-0.05, help="numerical damping, from -1/3 to 0")
    parser.add_argument("--connect", required=True, help="where the coupler listens; the coupler adds this")
    arguments = parser.parse_args()
    if shutil.which(arguments.program) is None:
        print(f"there is no program {arguments.program}: install CalculiX (Debian: calculix-ccx)", file=sys.stderr)
        sys.exit(2)
    structure = CalculixStructure(arguments.program, arguments.deck, arguments.surface, arguments.alpha)
    sys.exit(main(structure, arguments.connect))
