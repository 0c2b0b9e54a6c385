// SPDX-License-Identifier: GPL-3.0-or-later
// The quick T-10 with fewer steps of the flow and of the coupled run: every config passes its check, every
// stage ends well, the coupled steps converge, and a solver's death in between changes nothing.
#include "tests/support/processes.hpp"
#include "tests/support/t10_quick.hpp"

namespace drogue::test {
namespace {

TEST_F(T10Quick, RunsFromTheFlatPatternToCoupledSteps) {
  run("parachute_mesher", "check", "parachute.textproto");
  prepare();
  run("structure_solver", "check", "inflation.textproto");
  run("fluid_solver", "check", "flow.textproto");
  run("coupler", "check", "case.textproto");
  EXPECT_EQ(read_text(folder_ / "output.txt"), "case.textproto: ok\n");
  change("case.textproto", "steps: 60 }", "steps: 2 } checkpoints { steps: 1 }");
  change("case.textproto", "\"coupled\"", "\"undisturbed/run\"");
  run("coupler", "run", "case.textproto");

  const Table drag = read_csv(folder_ / "undisturbed/run/drag.csv"),
              coupling = read_csv(folder_ / "undisturbed/run/coupling.csv");
  ASSERT_EQ(drag.rows.size(), 2u);
  for (std::size_t n = 0; n < 2; ++n) {
    EXPECT_EQ(drag.at(n, "converged"), 1);
    EXPECT_GT(drag.at(n, "force_z"), 0); // the flow from below lifts the canopy
  }
  for (std::size_t i = 0; i < coupling.rows.size(); ++i) EXPECT_LT(coupling.at(i, "force_defect"), 1e-12);
  EXPECT_LE(coupling.at(coupling.rows.size() - 1, "residual_relative"), 1e-3);

  change("case.textproto", "undisturbed/run", "killed/run");
  launcher::Process coupler = start_program(folder_, {"run", "case.textproto"});
  ASSERT_TRUE(eventually([&] { return has_checkpoint(folder_ / "killed", 1); }, 300));
  std::mt19937 random(1);
  ASSERT_TRUE(kill_a_participant(coupler.pid(), folder_ / "killed", random));
  const auto exit = coupler.wait(std::chrono::minutes(5));
  ASSERT_TRUE(exit.has_value() && exit->clean()) << read_text(folder_ / "output.txt");
  EXPECT_NE(read_text(folder_ / "output.txt").find("restart 1 of at most 3"), std::string::npos);
  expect_same(everything(folder_ / "undisturbed", 2), everything(folder_ / "killed", 2));
}

} // namespace
} // namespace drogue::test
