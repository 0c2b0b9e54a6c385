# SPDX-License-Identifier: GPL-3.0-or-later
"""scripts/lib/report.py on a small run written here: what it finds is drawn and summed up, what is missing is named."""
import contextlib
import io
import pathlib
import sys
import tempfile
import unittest

import matplotlib

matplotlib.use("Agg")
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts" / "lib"))
import coupled_run  # noqa: E402
import report  # noqa: E402
from result_files import NothingToDraw  # noqa: E402

LOG = """[2026-01-01 10:00:00.000] [coupler] [info] step 1/40  t 0.1  2 iterations  residual 1.0e-04  1 s/step  39 s left
[2026-01-01 10:00:01.000] [coupler] [warning] step 7 <slow>
[2026-01-01 10:00:40.000] [coupler] [info] step 40/40  t 4  2 iterations  residual 1.0e-04  1 s/step  0 s left
[2026-01-01 10:00:40.000] [coupler] [info] time 40.0 s: structure 10.0 s (25 %), mesh_mover 5.0 s (12 %), fluid 24.0 s (60 %), coupler and transport 1.0 s
"""


def write_run(root: pathlib.Path):
    """Forty steps of two iterations; step 3 was tried, rolled back and done again, step 5 did not converge."""
    folder = root / "coupled"
    (folder / "structure").mkdir(parents=True)
    times = [0.1 * (i + 1) for i in range(40)]
    drag = ["time,force_x,force_y,force_z,cd,iterations,converged"]
    coupling = ["step,attempt,iteration,time,residual_relative,force_defect"]
    for i, time in enumerate(times):
        drag.append(f"{time},0,1,{500 + i % 4},0.7,2,{0 if i == 4 else 1}")
        if i == 2:
            coupling.append(f"3,1,1,{time - 0.05},0.9,1e-15")
        for iteration, residual in ((1, 1.0), (2, 2e-3 if i == 4 else 1e-4)):
            coupling.append(f"{i + 1},{2 if i == 2 else 1},{iteration},{time},{residual},1e-15")
    (folder / "drag.csv").write_text("\n".join(drag) + "\n")
    (folder / "coupling.csv").write_text("\n".join(coupling) + "\n")
    (folder / "structure" / "structure.csv").write_text(
        "time,weight_x,weight_y,weight_z,line_force_risers_x,line_force_risers_y,line_force_risers_z\n"
        + "".join(f"{time},0,0,-304,0,0,250\n" for time in times))
    (folder / "coupler.log").write_text(LOG)
    (folder / "case.textproto").write_text('# name: "wrong"\nname: "trial"\n')


class ReportTest(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.root = pathlib.Path(self.temporary.name)

    def test_reads_a_run(self):
        write_run(self.root)
        run = coupled_run.CoupledRun.find(self.root)
        self.assertEqual(run.name, "trial")
        last = run.last_iterations()
        self.assertEqual(list(last["step"]), list(range(1, 41)))
        self.assertEqual(list(last["iteration"]), [2] * 40)
        self.assertEqual(run.time_by_process(),
                         {"structure": 10, "mesh_mover": 5, "fluid": 24, "coupler and transport": 1})
        self.assertEqual(len(run.warnings()), 1)

    def test_says_what_is_there_and_what_is_not(self):
        write_run(self.root)
        file = self.root / "out" / "report.html"
        with contextlib.redirect_stderr(io.StringIO()) as said:
            status = report.write_report([coupled_run.CoupledRun.find(self.root)], file)
        self.assertEqual(status, 0)
        text = file.read_text()
        self.assertIn("<h1>trial</h1>", text)
        self.assertIn("1 (t = 0.5)", text)  # the step that did not converge
        self.assertIn("step 7 &lt;slow&gt;", text)
        for name in ("drag", "spectrum", "forces", "residual", "time"):
            self.assertTrue((file.parent / f"{name}.png").stat().st_size > 1000, name)
            self.assertIn(f"alt='{name}'", text)
        self.assertIn("velocities.png left out", said.getvalue())
        self.assertIn("no step has the fields of both", text)
        self.assertNotIn("http", text)

    def test_a_folder_without_a_coupled_run_is_named(self):
        with self.assertRaisesRegex(NothingToDraw, "no coupling.csv below"):
            coupled_run.CoupledRun.find(self.root)


if __name__ == "__main__":
    unittest.main()
