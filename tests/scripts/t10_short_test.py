# SPDX-License-Identifier: GPL-3.0-or-later
"""The short variant of a case of configs/t10 from the meshes to the report: t10_short_test.py CASE BIN RUNS, with the folders
of the programs and of the runs. Stages of other cases that the case goes on from are taken over from there."""
import pathlib
import shutil
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts" / "lib"))
from coupled_run import CoupledRun  # noqa: E402
from impulse import largest_defect  # noqa: E402

CASE, BIN, RUNS = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
STEPS = {"compatible": 4, "incompatible": 4, "free_fall": 5, "soft_landing": 4}
PICTURES = {"inflated", "flow", "instants", "drag", "forces", "impulse", "residual", "time"}
OF_THE_PAYLOAD = {"velocities", "positions"}


def call(script: str, *arguments: str) -> subprocess.CompletedProcess:
    return subprocess.run([str(ROOT / "scripts" / script), *arguments], capture_output=True, text=True)


class T10Short(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = RUNS / f"t10-{CASE}-short"
        shutil.rmtree(cls.folder, ignore_errors=True)
        made = cls.demo()
        if made.returncode != 0:
            raise AssertionError(made.stdout[-3000:] + made.stderr[-3000:])
        cls.run_ = CoupledRun.find(cls.folder)

    @classmethod
    def demo(cls):
        return call("demo", f"t10/{CASE}", "short", "--until", "coupled", "--bin", BIN, "--runs", str(RUNS))

    def test_every_step_converged_with_balanced_forces(self):
        drag, last = self.run_.drag(), self.run_.last_iterations()
        self.assertEqual(len(drag["time"]), STEPS[CASE])
        self.assertTrue((drag["converged"] == 1).all())
        self.assertTrue((drag["force_z"] > 0).all())
        self.assertLessEqual(last["residual_relative"].max(), 1e-3)
        self.assertLess(self.run_.coupling()["force_defect"].max(), 1e-12)

    def test_momentum_changes_by_the_impulse(self):
        series = self.run_.structure()
        self.assertLess(largest_defect(series), 0.01)
        free = CASE in ("free_fall", "soft_landing")
        self.assertEqual(abs(series["weight_z"][0]) > 300, free)

    def test_goes_on_where_the_other_case_ended(self):
        if CASE == "soft_landing":
            before = CoupledRun.find(RUNS / "t10-free_fall-short").structure()
            here = self.run_.structure()
            step = here["time"][1] - here["time"][0]
            self.assertAlmostEqual(here["time"][0], before["time"][-1] + step, places=12)
            # smooth: the momentum has no jump larger than its change in the steps around
            change = abs(here["momentum_z"][0] - before["momentum_z"][-1])
            around = max(abs(here["momentum_z"][1] - here["momentum_z"][0]),
                         abs(before["momentum_z"][-1] - before["momentum_z"][-2]))
            self.assertLess(change, 2 * around)
        if CASE == "incompatible":
            self.assertTrue((self.folder / "projected.state").exists())
            self.assertFalse((self.folder / "fluid.msh").exists())

    def test_nothing_is_done_twice(self):
        again = self.demo()
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertNotIn("done in", again.stderr)
        self.assertIn("unchanged: coupled/drag.csv is there", again.stderr)

    def test_the_report_has_every_picture(self):
        made = call("report", str(self.folder))
        self.assertEqual(made.returncode, 0, made.stderr)
        drawn = {file.stem for file in (self.folder / "report").glob("*.png")}
        expected = PICTURES | (OF_THE_PAYLOAD if CASE in ("free_fall", "soft_landing") else set())
        self.assertEqual(drawn, expected)
        text = (self.folder / "report" / "report.html").read_text()
        self.assertIn(f"t10-{CASE}-short", text)
        self.assertNotIn("class='number bad'", text)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
