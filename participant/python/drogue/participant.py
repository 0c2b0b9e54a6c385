# SPDX-License-Identifier: GPL-3.0-or-later
"""The SDK of a Drogue participant in Python: derive from Solver, call serve().

    CONNECTED --Hello--> GREETED --Configure--> CONFIGURED --Initialize--> READY
    READY --BeginStep--> IN_STEP --Iterate--> ITERATED --Iterate--> ITERATED --Commit--> READY
                         IN_STEP, ITERATED --Rollback--> READY
    READY --Checkpoint--> READY      READY --Restore--> READY      READY --ReplaceMesh--> READY
    Shutdown and Abort from anywhere; after an error that is not retryable: FAILED.

The messages are documented in proto/drogue/v1/wire.proto; this is the same machine as participant/cpp.
"""

import os
import sys
import traceback
from dataclasses import dataclass, field

import numpy as np

from drogue import wire
from drogue.keys import KeyProblem
from drogue.transport import Lost, Transport, TransportFailure
from drogue.v1 import wire_pb2
from drogue.v1.wire_pb2 import FieldContract

Error = wire_pb2.Error

TRANSITIONS = {
    ("GREETED", "configure"): "CONFIGURED",
    ("CONFIGURED", "initialize"): "READY",
    ("READY", "begin_step"): "IN_STEP",
    ("IN_STEP", "iterate"): "ITERATED",
    ("ITERATED", "iterate"): "ITERATED",
    ("ITERATED", "commit"): "READY",
    ("IN_STEP", "rollback"): "READY",
    ("ITERATED", "rollback"): "READY",
    ("READY", "checkpoint"): "READY",
    ("READY", "restore"): "READY",
    ("READY", "replace_mesh"): "READY",
}


# Arrays of elements that an interface may have, and the nodes of an element.
ELEMENT_ARRAYS = {"lines": 2, "lines3": 3, "triangles": 3, "triangles6": 6, "quadrangles4": 4, "quadrangles9": 9}


class SolverError(Exception):
    """A failure of the solver. `code` is one of drogue.v1.Error.Code; a retryable one leaves the solver ready for
    rollback, any other ends the participant."""

    def __init__(self, message, code=Error.NUMERICAL, retryable=False):
        super().__init__(message)
        self.code, self.retryable = code, retryable


class PeerError(Exception):
    """The coupler is gone, silent, or aborted the run."""


@dataclass
class Description:
    """What a participant says of itself before anything is computed; inputs and outputs are made by field_contract()."""

    software: str
    can_rollback: bool = True
    can_checkpoint: bool = False
    variable_step: bool = True
    can_replace_mesh: bool = False
    inputs: list = field(default_factory=list)
    outputs: list = field(default_factory=list)


@dataclass
class InterfaceMesh:
    """The surface that exchanges. See Initialized in wire.proto."""

    points: np.ndarray  # {n, 3}: positions at Initialize
    # {m, nodes of the element}: indices into points, in Gmsh's order. Lines are the interface of a plane problem. On a
    # fluid the normal points into the wall; that of a line lies to the right of its direction.
    lines: np.ndarray = None
    lines3: np.ndarray = None
    triangles: np.ndarray = None
    triangles6: np.ndarray = None
    quadrangles4: np.ndarray = None
    quadrangles9: np.ndarray = None
    reference: np.ndarray = None  # {n, 3}
    material: np.ndarray = None  # {n, 3}
    velocity: np.ndarray = None  # {n, 3}: at Initialize, of a structure that does not start at rest
    mesh_nodes: np.ndarray = None  # {n}: index of each interface node in the whole mesh
    mesh_node_count: int = 0
    mesh_hash: str = ""


@dataclass
class Report:
    """What an iterate did inside."""

    inner_iterations: int = 0
    inner_residual: float = 0.0
    converged: bool = True
    fixed_iterations: bool = False  # a fixed number in each call: the coupler judges inner_residual, not converged


@dataclass
class ReplacedMesh:
    """What a participant holds after replace_mesh(). See Replaced in wire.proto."""

    mesh_nodes: np.ndarray  # {n}: of each interface node, in the order of initialize()
    mesh_node_count: int
    mesh_hash: str
    mass_defect: float = 0.0
    momentum_defect: float = 0.0
    energy_defect: float = 0.0


class Solver:
    """A participant's solver; serve() calls these from one thread, in the order of the table above.

    iterate() must be deterministic: from the same begin_step() state, the same sequence of inputs gives the same
    outputs to the bit. rollback() restores exactly the state at begin_step()."""

    def describe(self):
        """Returns a Description."""
        raise NotImplementedError

    # True in a resumed run: `directory` holds the results of the part that was done before. They stay; restore() follows
    # initialize() and says where they go on.
    resumed = False

    def configure(self, directory, start_time, time_step):
        """`directory` is where results go."""

    def initialize(self):
        """Returns an InterfaceMesh."""
        raise NotImplementedError

    def begin_step(self, step, attempt, time, time_step):
        """Saves what rollback() needs. `time` is t_n."""

    def iterate(self, inputs):
        """Takes and returns arrays {nodes, components} by name; returns (outputs, Report). The inputs lie where they were
        received, and are the solver's to keep or change."""
        raise NotImplementedError

    def commit(self, write_output):
        """Makes the last iterate the state at t_{n+1}."""

    def rollback(self):
        """Back to the state at begin_step()."""

    def new_mesh(self):
        """Asked of a mesh mover after every commit: (file, mesh hash, reason) of the mesh that should take the place of
        its own, or None. See NewMesh in wire.proto."""
        return None

    def replace_mesh(self, file, mesh_hash, restoring):
        """Goes over to another mesh of the same domain and boundaries, between two steps; returns a ReplacedMesh. See
        ReplaceMesh in wire.proto. `restoring`: restore() follows, and brings the state."""
        raise NotImplementedError

    def checkpoint(self, directory):
        """Saves the committed state into files of any names in `directory`, which exists."""

    def restore(self, directory):
        """Reads what checkpoint() saved; in a resumed run also cuts series of results to their length then."""


def field_contract(name, quantity, location, components, time_level="END_OF_STEP", optional=False):
    """A contract entry; quantity, location and time level by their names in wire.proto."""
    return FieldContract(
        name=name,
        quantity=FieldContract.Quantity.Value(quantity),
        location=FieldContract.Location.Value(location),
        time_level=FieldContract.TimeLevel.Value(time_level),
        components=components,
        optional=optional,
    )


class _Server:
    """Checks every request against the table and the field contract, calls the solver, and sends the answer."""

    def __init__(self, solver, transport, run_id):
        self.solver, self.transport, self.run_id = solver, transport, run_id
        self.description = solver.describe()
        self.state = "CONNECTED"
        self.nodes = {FieldContract.INTERFACE_NODES: 0, FieldContract.MESH_NODES: 0, FieldContract.GLOBAL: 1}
        self.time_step = None
        self.failure = None

    def run(self, deadline):
        self.say_hello()
        while self.state not in ("FINISHED", "FAILED"):
            self.answer(self.transport.next_request(deadline))
        self.transport.flush(5)
        if self.failure:
            raise self.failure

    def say_hello(self):
        message = wire.Message()
        d = self.description
        message.envelope.hello.CopyFrom(
            wire_pb2.Hello(
                min_version=wire.VERSION,
                max_version=wire.VERSION,
                software=d.software,
                pid=[os.getpid()],
                can_rollback=d.can_rollback,
                can_checkpoint=d.can_checkpoint,
                variable_step=d.variable_step,
                can_replace_mesh=d.can_replace_mesh,
                input=d.inputs,
                output=d.outputs,
            )
        )
        self.transport.post(message)
        self.state = "GREETED"

    def answer(self, request):
        asked = request.envelope
        reply = wire.Message()
        reply.envelope.request_id, reply.envelope.step = asked.request_id, asked.step
        reply.envelope.iteration, reply.envelope.attempt = asked.iteration, asked.attempt
        kind = asked.WhichOneof("body") or "nothing"
        admitted = False
        try:
            self.admit(asked, kind)
            admitted = True
            getattr(self, "do_" + kind)(getattr(asked, kind), request, reply)
            self.state = TRANSITIONS.get((self.state, kind), self.state if self.failure is None else "FAILED")
            if kind == "shutdown":
                self.state = "FINISHED"
            if reply.envelope.WhichOneof("body") is None:
                reply.envelope.done.SetInParent()
        except SolverError as error:
            self.refuse(reply, error, admitted)
        except Exception as error:  # a bug in the solver must reach the coupler, not hang it
            traceback.print_exc()
            self.refuse(reply, SolverError(f"{type(error).__name__}: {error}", Error.INTERNAL), admitted)
        self.transport.post(reply)

    def refuse(self, reply, error, admitted):
        reply.arrays.clear()
        reply.envelope.error.code = error.code
        reply.envelope.error.message = str(error)
        reply.envelope.error.retryable = error.retryable
        # A request that does not fit, or a step too large, leaves the participant as it was; the rest is fatal.
        if admitted and not error.retryable and error.code not in (Error.BAD_MESSAGE, Error.NOT_FINITE):
            self.failure, self.state = error, "FAILED"

    def admit(self, asked, kind):
        if asked.run_id != self.run_id:
            raise SolverError(f'run "{self.run_id}" expected, got "{asked.run_id}"', Error.BAD_MESSAGE)
        if kind not in ("shutdown", "abort") and (self.state, kind) not in TRANSITIONS:
            name = "".join(part.capitalize() for part in kind.split("_"))
            raise SolverError(f"{name} is not allowed in state {self.state}", Error.WRONG_STATE)

    def do_configure(self, body, request, reply):
        if body.version != wire.VERSION:
            raise SolverError(f"protocol version {wire.VERSION} expected, got {body.version}", Error.UNSUPPORTED)
        self.time_step = body.time_step
        self.solver.resumed = body.resume
        self.solver.configure(body.directory, body.start_time, body.time_step)

    def do_initialize(self, body, request, reply):
        mesh = self.solver.initialize()
        reply.envelope.initialized.mesh_node_count = mesh.mesh_node_count
        reply.envelope.initialized.mesh_hash = mesh.mesh_hash
        for name, columns in (("points", 3), ("reference", 3), ("material", 3), ("velocity", 3)):
            if getattr(mesh, name) is not None:
                reply.arrays[name] = np.asarray(getattr(mesh, name), dtype=np.float64).reshape(-1, columns)
        for name, columns in ELEMENT_ARRAYS.items():
            if getattr(mesh, name) is not None:
                reply.arrays[name] = np.asarray(getattr(mesh, name), dtype=np.int64).reshape(-1, columns)
        if mesh.mesh_nodes is not None:
            reply.arrays["mesh_nodes"] = np.asarray(mesh.mesh_nodes, dtype=np.int64)
        self.nodes[FieldContract.INTERFACE_NODES] = len(mesh.points)
        self.nodes[FieldContract.MESH_NODES] = mesh.mesh_node_count

    def do_begin_step(self, body, request, reply):
        if not self.description.variable_step and body.time_step != self.time_step:
            raise SolverError(f"the step is fixed at {self.time_step}, asked for {body.time_step}", Error.UNSUPPORTED)
        asked = request.envelope
        self.solver.begin_step(asked.step, asked.attempt, body.time, body.time_step)

    def do_iterate(self, body, request, reply):
        self.check_fields(self.description.inputs, request.arrays, "input")
        outputs, report = self.solver.iterate(request.arrays)
        try:
            self.check_fields(self.description.outputs, outputs, "output")
        except SolverError as error:
            raise SolverError(str(error), Error.NUMERICAL, error.code == Error.NOT_FINITE) from error
        reply.arrays.update({name: np.asarray(values, dtype=np.float64) for name, values in outputs.items()})
        reply.envelope.iterated.inner_iterations = report.inner_iterations
        reply.envelope.iterated.inner_residual = report.inner_residual
        reply.envelope.iterated.converged = report.converged
        reply.envelope.iterated.fixed_iterations = report.fixed_iterations

    def do_commit(self, body, request, reply):
        self.solver.commit(body.write_output)
        mesh = self.solver.new_mesh()
        reply.envelope.done.SetInParent()
        if mesh is not None:
            new = reply.envelope.done.new_mesh
            new.file, new.mesh_hash, new.reason = str(mesh[0]), mesh[1], mesh[2]

    def do_replace_mesh(self, body, request, reply):
        self.need(self.description.can_replace_mesh, "replace its mesh")
        mesh = self.solver.replace_mesh(body.file, body.mesh_hash, body.restoring)
        if len(mesh.mesh_nodes) != self.nodes[FieldContract.INTERFACE_NODES]:
            raise SolverError(f"the new mesh has {len(mesh.mesh_nodes)} interface nodes", Error.INTERNAL)
        replaced = reply.envelope.replaced
        replaced.mesh_node_count, replaced.mesh_hash = mesh.mesh_node_count, mesh.mesh_hash
        replaced.mass_defect, replaced.momentum_defect = mesh.mass_defect, mesh.momentum_defect
        replaced.energy_defect = mesh.energy_defect
        reply.arrays["mesh_nodes"] = np.asarray(mesh.mesh_nodes, dtype=np.int64)
        self.nodes[FieldContract.MESH_NODES] = mesh.mesh_node_count

    def do_rollback(self, body, request, reply):
        self.need(self.description.can_rollback, "roll back")
        self.solver.rollback()

    def do_checkpoint(self, body, request, reply):
        self.need(self.description.can_checkpoint, "checkpoint")
        self.solver.checkpoint(body.directory)

    def do_restore(self, body, request, reply):
        self.need(self.description.can_checkpoint, "checkpoint")
        self.solver.restore(body.directory)

    def do_shutdown(self, body, request, reply):
        pass

    def do_abort(self, body, request, reply):
        self.failure = PeerError("the coupler aborted the run: " + body.reason)

    @staticmethod
    def need(capability, what):
        if not capability:
            raise SolverError(f"this participant cannot {what}", Error.UNSUPPORTED)

    def check_fields(self, contract, arrays, what):
        for entry in contract:
            if entry.name not in arrays:
                if entry.optional:
                    continue
                raise SolverError(f'{what} "{entry.name}" is missing', Error.BAD_MESSAGE)
            values = np.asarray(arrays[entry.name])
            expected = (self.nodes[entry.location], entry.components)
            if values.shape != expected or not np.issubdtype(values.dtype, np.number):
                raise SolverError(
                    f'{what} "{entry.name}" has shape {_braces(values.shape)}, expected {_braces(expected)}',
                    Error.BAD_MESSAGE,
                )
            bad = np.argwhere(~np.isfinite(values))
            if len(bad):
                raise SolverError(
                    f'{what} "{entry.name}" is not finite at node {bad[0][0]}, component {bad[0][1]}', Error.NOT_FINITE
                )


def _braces(shape):
    return "{" + ", ".join(str(extent) for extent in shape) + "}"


_transport = None


def report_progress(phase, inner_iteration=0, inner_residual=0.0):
    """What the solver does, for the beats; may be called from inside iterate() at any rate."""
    if _transport is not None:
        _transport.progress = (phase, int(inner_iteration), float(inner_residual))


def serve(solver, endpoint, participant=None, run_id=None, deadline=None):
    """Connects and serves until Shutdown. Name, run id and deadline in seconds default to what the coupler's launcher
    sets: DROGUE_PARTICIPANT, DROGUE_RUN_ID, DROGUE_PEER_DEADLINE (one hour when not set). A coupler on another machine
    must have keys: DROGUE_KEY, the file of the participant's own pair, and DROGUE_COUPLER_KEY, the coupler's public key.

    Raises SolverError, or PeerError when the coupler is gone, silent beyond the deadline, or aborts, or
    TransportFailure."""
    global _transport
    participant = participant or os.environ.get("DROGUE_PARTICIPANT", "")
    run_id = run_id if run_id is not None else os.environ.get("DROGUE_RUN_ID", "")
    deadline = deadline or _positive(os.environ.get("DROGUE_PEER_DEADLINE", "")) or 3600.0
    if not participant:
        raise SolverError(
            "the name of the participant is not known: start it through the coupler, or set DROGUE_PARTICIPANT to "
            "fluid, structure or mesh_mover",
            Error.CONFIGURATION,
        )
    own_keys = os.environ.get("DROGUE_KEY", ""), os.environ.get("DROGUE_COUPLER_KEY", "")
    transport = Transport(endpoint, participant, run_id, *own_keys)
    try:
        try:
            transport.start()
        except KeyProblem as error:
            raise SolverError(str(error), Error.CONFIGURATION) from error
        _transport = transport
        try:
            _Server(solver, transport, run_id).run(deadline)
        finally:
            _transport = None
            transport.close()
    except Lost as error:
        raise PeerError(f"{participant}: {error}") from error


def _positive(text):
    try:
        return max(float(text), 0.0)
    except ValueError:
        return 0.0


def main(solver, endpoint):
    """serve() for a program: returns the exit status (0 done, 1 internal, 2 config, 3 numerical, 4 coupler gone) and
    prints the error."""
    try:
        serve(solver, endpoint)
    except PeerError as error:
        print(error, file=sys.stderr)
        return 4
    except TransportFailure as error:
        print(error, file=sys.stderr)
        return 1
    except SolverError as error:
        print(error, file=sys.stderr)
        return {Error.CONFIGURATION: 2, Error.UNSUPPORTED: 2, Error.NUMERICAL: 3}.get(error.code, 1)
    return 0
