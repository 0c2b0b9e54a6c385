# SPDX-License-Identifier: GPL-3.0-or-later
"""A mass on a spring in smaller steps than those of the coupling, against the same solver that takes the small steps."""

import tempfile
import unittest

import numpy as np
from drogue.participant import Description, Report, field_contract
from drogue.subcycled import PartedSolver, Subcycled


class Spring(PartedSolver):
    """d'' + 4 d = f by the trapezoidal rule."""

    def __init__(self):
        self.n = self.now = (0.0, 0.0, 0.0)
        self.start = None

    def describe(self):
        return Description(
            "spring", outputs=[field_contract("mean_d", "DISPLACEMENT", "INTERFACE_NODES", 1, "MEAN_OF_STEP")]
        )

    def begin_step(self, step, attempt, time, time_step):
        self.h = time_step

    def iterate(self, inputs):
        d, v, a = self.n
        guess = d + self.h * v + 0.25 * self.h**2 * a
        a1 = (inputs["force"][0, 0] - 4 * guess) / (1 + self.h**2)
        d1 = guess + 0.25 * self.h**2 * a1
        self.now = (d1, v + 0.5 * self.h * (a + a1), a1)
        return {"d": np.array([[d1]]), "mean_d": np.array([[(d + d1) / 2]])}, Report(1)

    def commit(self, write_output):
        self.n, self.start = self.now, None

    def end_part(self):
        self.start = self.start or self.n
        self.n = self.now

    def undo_parts(self):
        self.n, self.start = self.start or self.n, None

    def checkpoint(self, directory):
        np.save(directory + "/spring.npy", self.n)

    def restore(self, directory):
        self.n = tuple(np.load(directory + "/spring.npy"))


def step(solver, time, time_step, force, iterates=1):
    solver.begin_step(1, 1, time, time_step)
    for k in reversed(range(iterates)):
        outputs, _ = solver.iterate({"force": np.array([[force(time + time_step) + 7.0 * k]])})
    solver.commit(False)
    return outputs


def motion(force, steps, parts, quadratic=False, iterates=1):
    solver = Subcycled(Spring(), parts, quadratic)
    solver.describe()
    for k in range(steps):
        outputs = step(solver, 2 * k / steps, 2 / steps, force, iterates)
    return outputs["d"][0, 0]


def line(t):
    return 1 if t < 0.25 else 0.5 + 2 * t


def parabola(t):
    return 1.5 if t < 0.25 else 1 + 2 * t + (4 * (t - 0.25) * (t - 0.5) if t > 0.5 else 0)


class SubcycledTest(unittest.TestCase):
    def test_does_what_the_solver_does_in_small_steps(self):
        self.assertAlmostEqual(motion(line, 8, 5, iterates=3), motion(line, 40, 1), delta=1e-13)
        self.assertAlmostEqual(motion(parabola, 8, 5, True, iterates=2), motion(parabola, 40, 1), delta=1e-13)
        self.assertGreater(abs(motion(parabola, 8, 5) - motion(parabola, 40, 1)), 1e-4)

    def test_gives_the_mean_of_all_parts(self):
        whole, parted = Spring(), Subcycled(Spring(), 2)
        parted.describe()
        means = [step(whole, t, 0.1, lambda t: 1.0)["mean_d"][0, 0] for t in (0, 0.1)]
        self.assertAlmostEqual(step(parted, 0, 0.2, lambda t: 1.0)["mean_d"][0, 0], sum(means) / 2, delta=1e-15)

    def test_leads_an_input_from_its_start_to_its_end(self):
        solver = Subcycled(Spring(), 4, True)
        inputs = {"velocity_start": np.array([[1.0]]), "velocity": np.array([[3.0]])}
        part = solver.inputs_of_part(inputs, 0.25, 0.5)
        self.assertEqual([part[name][0, 0] for name in ("velocity_start", "velocity")], [1.5, 2.0])

    def test_resumes(self):
        first, second = Subcycled(Spring(), 3, True), Subcycled(Spring(), 3, True)
        for k in range(2):
            step(first, 0.2 * k, 0.2, np.cos)
        with tempfile.TemporaryDirectory() as folder:
            first.checkpoint(folder)
            second.restore(folder)
        self.assertEqual(step(first, 0.4, 0.1, np.cos)["d"], step(second, 0.4, 0.1, np.cos, 2)["d"])


if __name__ == "__main__":
    unittest.main()
