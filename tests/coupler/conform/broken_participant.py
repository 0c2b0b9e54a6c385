# SPDX-License-Identifier: GPL-3.0-or-later
"""A participant that breaks one promise of the protocol: broken_participant.py FAULT --connect ENDPOINT

A point mass in a plane of three nodes, through the SDK; each fault replaces the piece of solver or SDK that keeps the
promise. FAULT "none" breaks nothing.
"""

import os
import subprocess
import sys
import time

import numpy as np

import drogue.participant as sdk
from drogue import wire
from drogue.participant import Description, Error, InterfaceMesh, Report, Solver, SolverError, field_contract
from drogue.transport import Transport

FAULT = sys.argv[1]
STATE = "mass.npy"


class Mass(Solver):
    """d, v of the committed state and of the last iterate; the load's sum moves it."""

    def __init__(self):
        self.n = np.zeros(2)
        self.now = self.n.copy()
        self.iterates = 0

    def describe(self):
        quantity = "TRACTION" if FAULT == "contract" else "DISPLACEMENT"
        outputs = [field_contract("displacement", quantity, "INTERFACE_NODES", 3)]
        if FAULT != "no_velocity":
            outputs.append(field_contract("velocity", "VELOCITY", "INTERFACE_NODES", 3))
        return Description(
            software="broken_participant " + FAULT,
            can_checkpoint=True,
            inputs=[field_contract("force", "FORCE", "INTERFACE_NODES", 3)],
            outputs=outputs,
        )

    def initialize(self):
        if FAULT == "too_early" and self.resumed:
            self.write("nothing")
        triangles = [[0, 1, 3 if FAULT == "interface" else 2]]
        return InterfaceMesh(points=np.eye(3), triangles=np.array(triangles), mesh_node_count=3)

    def begin_step(self, step, attempt, time, time_step):
        if FAULT == "step_length" and time_step != self.time_step:
            raise SolverError("not a step of that length")
        self.dt, self.step = time_step, step

    def configure(self, directory, start_time, time_step):
        self.directory, self.time_step = directory, time_step

    def write(self, text):
        with open(os.path.join(self.directory, "result.txt"), "w", encoding="utf-8") as file:
            file.write(text)

    def iterate(self, inputs):
        force = inputs["force"].sum() if inputs["force"].shape == (3, 3) else 0.0
        if FAULT == "deterministic":
            force += 1e-9 * os.getpid()
        if FAULT == "beats" and self.step == 1 and os.environ["DROGUE_RUN_ID"] == "conform-reference":
            time.sleep(3.2)
        self.iterates += 1
        v = self.n[1] + self.dt * np.nan_to_num(force)
        self.now = np.array([self.n[0] + self.dt * v, v])
        if FAULT == "refusals":
            self.now[0] += self.refused
        if FAULT == "repeat":
            self.now[0] += self.iterates
        outputs = {"displacement": np.full((3, 3), self.now[0]), "velocity": np.full((3, 3), self.now[1])}
        if FAULT == "shape":
            outputs["velocity"] = np.zeros((2, 3))
        if FAULT == "nan":
            outputs["velocity"] *= np.nan
        if FAULT == "missing_output":
            del outputs["velocity"]
        return outputs, Report(1, 0.0, True)

    refused = 0

    def commit(self, write_output):
        self.n = self.now.copy()
        self.iterates = 0
        self.write(f"{self.step} {self.n}")

    def rollback(self):
        if FAULT == "rollback":
            self.n = self.now.copy()
        self.now = self.n.copy()

    def checkpoint(self, directory):
        if FAULT != "empty_checkpoint":
            np.save(os.path.join(directory, STATE), self.n)
        if FAULT == "checkpoint":
            self.n = self.n + 1e-12

    def restore(self, directory):
        file = os.path.join(directory, STATE)
        if FAULT == "bad_checkpoint" and not os.path.exists(file):
            return
        if not os.path.exists(file):
            raise SolverError(f"{file}: there is no such file", Error.CONFIGURATION)
        self.n = np.load(file)
        if FAULT == "restore" or (FAULT == "resume" and self.resumed):
            self.n[1] = 0


class Server(sdk._Server):
    def say_hello(self):
        if FAULT == "hello":
            time.sleep(20)
        super().say_hello()

    def admit(self, asked, kind):
        if FAULT == "wrong_run":
            asked.run_id = self.run_id
        if FAULT == "wrong_state" and kind not in ("shutdown", "abort") and (self.state, kind) not in sdk.TRANSITIONS:
            raise SolverError("some other time", Error.BAD_MESSAGE)
        super().admit(asked, kind)

    def refuse(self, reply, error, admitted):
        if error.code in (Error.BAD_MESSAGE, Error.NOT_FINITE):
            self.solver.refused += 1
        super().refuse(reply, error, admitted)

    def do_configure(self, body, request, reply):
        if FAULT == "version_refused":
            body.version = wire.VERSION
        super().do_configure(body, request, reply)

    def do_replace_mesh(self, body, request, reply):
        if FAULT != "bad_mesh":
            super().do_replace_mesh(body, request, reply)

    def do_iterate(self, body, request, reply):
        if FAULT == "missing_input":
            request.arrays.setdefault("force", np.zeros((3, 3)))
        if FAULT == "not_finite" and "force" in request.arrays:
            request.arrays["force"] = np.nan_to_num(request.arrays["force"])
        super().do_iterate(body, request, reply)

    def check_fields(self, contract, arrays, what):
        if FAULT == "bad_shape" and what == "input" and "force" in arrays and arrays["force"].shape != (3, 3):
            return
        if FAULT in ("shape", "nan", "missing_output") and what == "output":
            return
        super().check_fields(contract, arrays, what)

    def do_shutdown(self, body, request, reply):
        if FAULT == "shutdown" and self.state == "ITERATED":
            os._exit(3)

    def do_abort(self, body, request, reply):
        if FAULT != "abort":
            super().do_abort(body, request, reply)
        self.state = "FINISHED"


class OwnTransport(Transport):
    def post(self, message):
        if FAULT == "version" and message.envelope.HasField("hello"):
            message.envelope.hello.min_version = message.envelope.hello.max_version = 2
        if FAULT == "processes" and message.envelope.HasField("hello"):
            del message.envelope.hello.pid[:]
        if FAULT == "orphans" and message.envelope.HasField("hello"):
            child = subprocess.Popen(["sleep", "8"], start_new_session=True)
            message.envelope.hello.pid.append(child.pid)
        if FAULT == "identity":
            self.participant = "somebody"
        super().post(message)

    def next_request(self, deadline):
        if FAULT == "pause":
            deadline = 1.0
        try:
            return super().next_request(deadline)
        except sdk.Lost:
            if (FAULT == "coupler_death" and self._lost) or (FAULT == "silence" and not self._lost):
                os._exit(0)
            raise

    def _receive(self):
        if FAULT == "repeat":
            self._last_answer = None
        super()._receive()

    def _beat(self):
        if FAULT != "beats":
            super()._beat()


def careless_decode(frames, decode=wire.decode):
    """Takes what it can from a message with a wrong checksum."""
    try:
        return decode(frames)
    except wire.WireError as error:
        if "checksum" not in str(error):
            raise
        message = wire.Message()
        message.envelope.ParseFromString(frames[1])
        message.arrays["force"] = np.zeros((3, 3))
        return message


if FAULT == "malformed":
    wire.decode = careless_decode
sdk._Server, sdk.Transport = Server, OwnTransport
sys.exit(sdk.main(Mass(), sys.argv[-1]))
