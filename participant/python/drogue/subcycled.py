# SPDX-License-Identifier: GPL-3.0-or-later
"""A solver's own time steps within a step of the coupling; participant/cpp/subcycled.hpp in Python."""

import os

import numpy as np

from drogue.participant import Report, Solver
from drogue.v1.wire_pb2 import FieldContract


class PartedSolver(Solver):
    """A solver whose time step may be one of several parts of the coupling's:

        begin_step --iterate--> end_part, begin_step --iterate--> ... --iterate--> commit

    and from anywhere in there, after a rollback() of the part under way, undo_parts()."""

    def end_part(self):
        """Makes the last iterate the state at the end of a part; writes and counts nothing."""
        raise NotImplementedError

    def undo_parts(self):
        """The exact state before the first of the parts since the last commit()."""
        raise NotImplementedError


class Subcycled(Solver):
    """Takes each step of the coupling in `parts` equal steps of a PartedSolver, which must iterate to its own tolerance
    in each call. In every coupling iteration all parts are done anew.

    The inputs of a part are interpolated in time: in a line from the end of the last step, or (`quadratic`) through the
    end of the step before as well. An input X that comes with an input X_start goes in a line from this to that. In the
    first step of a run an input counts as constant. Outputs are those of the last part, or the means over the parts where
    the contract says so."""

    def __init__(self, inner, parts, quadratic=False):
        self.inner, self.parts, self.quadratic = inner, parts, quadratic
        self.given, self.last, self.before = {}, {}, {}
        self.last_time_step = 0.0
        self.in_part = False
        self.means = []

    def describe(self):
        description = self.inner.describe()
        self.means = [f.name for f in description.outputs if f.time_level == FieldContract.MEAN_OF_STEP]
        return description

    def configure(self, directory, start_time, time_step):
        self.inner.resumed = self.resumed
        self.inner.configure(directory, start_time, time_step)

    def initialize(self):
        return self.inner.initialize()

    def begin_step(self, step, attempt, time, time_step):
        self.step = step, attempt, time, time_step

    def iterate(self, inputs):
        self.rollback()
        step, attempt, time, time_step = self.step
        total, means = Report(), {}
        for k in range(self.parts):
            if k > 0:
                self.inner.end_part()
            self.in_part = False
            self.inner.begin_step(step, attempt, time + k * time_step / self.parts, time_step / self.parts)
            self.in_part = True
            outputs, report = self.inner.iterate(self.inputs_of_part(inputs, k / self.parts, (k + 1) / self.parts))
            total.inner_iterations += report.inner_iterations
            total.inner_residual = max(total.inner_residual, report.inner_residual)
            total.converged = total.converged and report.converged
            for name in self.means:
                if name in outputs:
                    means[name] = means.get(name, 0) + outputs[name] / self.parts
        self.given = {name: np.array(values) for name, values in inputs.items()}
        return {**outputs, **means}, total

    def inputs_of_part(self, inputs, begin, end):
        part = {}
        for name in inputs:
            of = name.removesuffix("_start")
            part[name] = self.at(inputs, of, begin) if of != name and of in inputs else self.at(inputs, name, end)
        return part

    def at(self, inputs, name, share):
        now = inputs[name]
        start = inputs.get(name + "_start")
        last = self.last.get(name) if start is None else start
        if last is None or last.shape != now.shape:
            return np.array(now)
        before = self.before.get(name)
        if not self.quadratic or start is not None or before is None or before.shape != now.shape:
            return share * now + (1 - share) * last
        b = self.last_time_step / self.step[3]
        return (
            share * (share + b) / (1 + b) * now
            + (1 - share) * (share + b) / b * last
            + share * (share - 1) / (b * (1 + b)) * before
        )

    def commit(self, write_output):
        self.inner.commit(write_output)
        self.in_part = False
        self.last, self.before, self.given = self.given, self.last, {}
        self.last_time_step = self.step[3]

    def rollback(self):
        if self.in_part:
            self.inner.rollback()
        self.in_part = False
        self.inner.undo_parts()

    def new_mesh(self):
        return self.inner.new_mesh()

    def replace_mesh(self, file, mesh_hash, restoring):
        self.last, self.before = {}, {}  # numbered as the old mesh
        return self.inner.replace_mesh(file, mesh_hash, restoring)

    def checkpoint(self, directory):
        self.inner.checkpoint(directory)
        levels = {f"last.{name}": values for name, values in self.last.items()}
        levels.update({f"before.{name}": values for name, values in self.before.items()})
        np.savez(os.path.join(directory, "subcycled.npz"), time_step=self.last_time_step, **levels)

    def restore(self, directory):
        self.inner.restore(directory)
        with np.load(os.path.join(directory, "subcycled.npz")) as saved:
            self.last_time_step = float(saved["time_step"])
            self.last = {name[5:]: saved[name] for name in saved.files if name.startswith("last.")}
            self.before = {name[7:]: saved[name] for name in saved.files if name.startswith("before.")}
