// SPDX-License-Identifier: GPL-3.0-or-later
// The quick T-10 hit by a gust on one flank that pushes the canopy in: the fluid's first mesh cannot follow,
// the run on it ends. With a limit on the distortion the mesh is replaced within the run of four processes,
// which goes on. Against the run on the first mesh, as far as that comes: the drag must not jump.
#include <algorithm>
#include <cmath>

#include "tests/support/t10_quick.hpp"
#include "tests/support/verify.hpp"

namespace drogue::test {
namespace {

constexpr int steps = 12;
constexpr int steps_on_two_ranks = 10;
constexpr const char* name = "mesh/remesh_t10_quick";

class Remesh : public T10Quick {
 protected:
  /// A flow of one second.
  void develop_the_flow() {
    run("parachute_mesher", "structure", "parachute.textproto");
    run("structure_solver", "run", "inflation.textproto");
    run("parachute_mesher", "fluid", "parachute.textproto");
    change("flow.textproto", "step: 0.03 steps: 100", "step: 0.03 steps: 30");
    run("fluid_solver", "run", "flow.textproto", std::chrono::minutes(20));
  }
  /// The gust, and so many coupled steps in kept/run.
  void write_case(int last) {
    change("structure.textproto", "t/0.1\\)\"", "t/0.1) - 3*min(1, t/0.02)*exp(-((x - 12)^2 + y^2)/40)\"");
    change("case.textproto", "steps: 60 }",
           fmt::format("steps: {} }} checkpoints {{ steps: 2 keep: 10 }}", last));
    change("case.textproto", "\"coupled\"", "\"kept/run\"");
  }
  [[nodiscard]] Table table(const std::string& file) const { return read_csv(folder_ / file); }
  void on_two_ranks() {
    change("case.textproto", "\"mesh.textproto\"", "\"mesh.textproto\" ranks: 2");
    change("case.textproto", "\"fluid.textproto\"", "\"fluid.textproto\" ranks: 2");
  }
  /// Everything a run left, and the same after a resume from the checkpoint of `from`.
  void expect_the_same_after_a_resume(const std::string& folder, int from, int last) {
    const auto expected = everything(folder_ / folder, last);
    ASSERT_TRUE(has_checkpoint(folder_ / folder, from));
    for (int step = from + 1; step <= last; ++step)
      std::filesystem::remove_all(checkpoint_folder(folder_ / folder, step));
    run("coupler", "resume", folder + "/run", std::chrono::minutes(30));
    expect_same(expected, everything(folder_ / folder, last));
  }
};

/// |b - a| / |a| of the drag of two runs after the step n + 1.
double drag_change(const Table& a, const Table& b, std::size_t n) {
  return std::abs(b.at(n, "force_z") - a.at(n, "force_z")) / std::abs(a.at(n, "force_z"));
}

TEST_F(Remesh, ACollapseGoesOnAndTheDragDoesNotJump) {
  develop_the_flow();
  write_case(steps);
  ASSERT_FALSE(HasFailure()) << "before the coupled runs";
  launcher::Process coupler = start_program(folder_, {"run", "case.textproto"});
  const auto exit = coupler.wait(std::chrono::minutes(30));
  EXPECT_TRUE(exit.has_value() && exit->status == 3) << read_text(folder_ / "output.txt");
  EXPECT_NE(read_text(folder_ / "output.txt").find("mesh_mover refused Iterate"), std::string::npos);
  change("case.textproto", "kept/run", "replaced/run");
  change("mesh.textproto", "tolerance: 1e-4", "tolerance: 1e-4\nremesh { mean_ratio: 0.2 angle: 5 }");
  run("coupler", "run", "case.textproto", std::chrono::minutes(30));

  const Table before = table("kept/run/drag.csv"), after = table("replaced/run/drag.csv"),
              events = table("replaced/run/remesh.csv");
  ASSERT_GE(events.rows.size(), 1u);
  ASSERT_EQ(after.rows.size(), static_cast<std::size_t>(steps));
  const auto first = static_cast<std::size_t>(events.at(0, "step"));
  ASSERT_LT(first, before.rows.size());
  for (std::size_t n = 0; n < first; ++n) EXPECT_EQ(after.at(n, "force_z"), before.at(n, "force_z"));
  double mass = 0, momentum = 0, energy = 0;
  for (std::size_t i = 0; i < events.rows.size(); ++i) {
    mass = std::max(mass, events.at(i, "mass_defect"));
    momentum = std::max(momentum, events.at(i, "momentum_defect"));
    energy = std::max(energy, events.at(i, "energy_defect"));
  }
  verify(name, "drag_jump", drag_change(before, after, first), 0, 0.02);
  verify(name, "mass_defect", mass, 0, 1e-3);
  verify(name, "momentum_defect", momentum, 0, 1e-3);
  verify(name, "energy_defect", energy, 0, 1e-2);
  // Once more from behind the replacement, and from before it: the same to the bit.
  expect_the_same_after_a_resume("replaced", 10, steps);
  expect_the_same_after_a_resume("replaced", 6, steps);

  // Fluid and mesh motion on two ranks each. What the loop's tolerance of 1e-3 leaves differs, and so does
  // the new mesh.
  change("case.textproto", "replaced/run", "ranks/run");
  change("case.textproto", fmt::format("steps: {} ", steps), fmt::format("steps: {} ", steps_on_two_ranks));
  on_two_ranks();
  run("coupler", "run", "case.textproto", std::chrono::minutes(30));
  const Table ranks = table("ranks/run/drag.csv"), ranks_events = table("ranks/run/remesh.csv");
  ASSERT_EQ(ranks.rows.size(), static_cast<std::size_t>(steps_on_two_ranks));
  ASSERT_GE(ranks_events.rows.size(), 1u);
  EXPECT_EQ(ranks_events.at(0, "step"), events.at(0, "step"));
  double differs = 0;
  for (std::size_t n = 0; n < first; ++n) differs = std::max(differs, drag_change(before, ranks, n));
  verify(name, "two_ranks_drag_before", differs, 0, 0.01);
  verify(name, "two_ranks_drag_jump", drag_change(before, ranks, first), 0, 0.02);
  verify(name, "two_ranks_mass_defect", ranks_events.at(0, "mass_defect"), 0, 1e-3);
  verify(name, "two_ranks_momentum_defect", ranks_events.at(0, "momentum_defect"), 0, 1e-3);
  expect_the_same_after_a_resume("ranks", 8, steps_on_two_ranks);
}

} // namespace
} // namespace drogue::test
