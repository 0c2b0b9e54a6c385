// SPDX-License-Identifier: GPL-3.0-or-later
// The quick T-10 with a limit on the mesh's distortion that its first steps break: the fluid's mesh is
// replaced within the run of four processes, which goes on. Against the same run on its first mesh: the drag
// must not jump.
#include <algorithm>
#include <cmath>

#include "tests/support/t10_quick.hpp"
#include "tests/support/verify.hpp"

namespace drogue::test {
namespace {

constexpr int steps = 24;

class Remesh : public T10Quick {
 protected:
  /// A developed flow before the coupled run, without the last fine steps of the demonstration.
  void SetUp() override {
    T10Quick::SetUp();
    run("parachute_mesher", "structure", "parachute.textproto");
    run("structure_solver", "run", "inflation.textproto");
    run("parachute_mesher", "fluid", "parachute.textproto");
    run("fluid_solver", "run", "flow.textproto", std::chrono::minutes(20));
    change("case.textproto", "steps: 60 }", fmt::format("steps: {} }} checkpoints {{ steps: 8 }}", steps));
    change("case.textproto", "\"coupled\"", "\"kept/run\"");
  }
  [[nodiscard]] Table table(const std::string& file) const { return read_csv(folder_ / file); }
};

TEST_F(Remesh, TheDragDoesNotJumpWhenTheMeshIsReplaced) {
  run("coupler", "run", "case.textproto", std::chrono::minutes(30));
  change("case.textproto", "kept/run", "replaced/run");
  change("mesh.textproto", "tolerance: 1e-4", "tolerance: 1e-4\nremesh { f_a: 0.1 }");
  run("coupler", "run", "case.textproto", std::chrono::minutes(30));

  const Table events = table("replaced/run/remesh.csv");
  ASSERT_GE(events.rows.size(), 1u);
  const Table before = table("kept/run/drag.csv"), after = table("replaced/run/drag.csv");
  ASSERT_EQ(before.rows.size(), static_cast<std::size_t>(steps));
  ASSERT_EQ(after.rows.size(), before.rows.size());
  // The replacement's own effect: against the run on the first mesh, in the step that follows and in all
  // later ones.
  const auto change_of = [&](std::size_t n) {
    return std::abs(after.at(n, "force_z") - before.at(n, "force_z")) / std::abs(before.at(n, "force_z"));
  };
  const auto first = static_cast<std::size_t>(events.at(0, "step"));
  ASSERT_LT(first, before.rows.size());
  for (std::size_t n = 0; n < first; ++n) EXPECT_EQ(after.at(n, "force_z"), before.at(n, "force_z"));
  double largest = 0, mass = 0, momentum = 0, energy = 0;
  for (std::size_t n = first; n < before.rows.size(); ++n) largest = std::max(largest, change_of(n));
  for (std::size_t i = 0; i < events.rows.size(); ++i) {
    mass = std::max(mass, events.at(i, "mass_defect"));
    momentum = std::max(momentum, events.at(i, "momentum_defect"));
    energy = std::max(energy, events.at(i, "energy_defect"));
  }
  verify("mesh/remesh_t10_quick", "drag_jump", change_of(first), 0, 0.02);
  verify("mesh/remesh_t10_quick", "largest_drag_change", largest, 0, 0.05);
  verify("mesh/remesh_t10_quick", "mass_defect", mass, 0, 1e-3);
  verify("mesh/remesh_t10_quick", "momentum_defect", momentum, 0, 1e-3);
  verify("mesh/remesh_t10_quick", "energy_defect", energy, 0, 1e-2);

  // From the checkpoint behind the first replacement on, once more: the same to the bit.
  const auto expected = everything(folder_ / "replaced", steps);
  ASSERT_TRUE(has_checkpoint(folder_ / "replaced", 16));
  std::filesystem::remove_all(checkpoint_folder(folder_ / "replaced", steps));
  run("coupler", "resume", "replaced/run", std::chrono::minutes(30));
  expect_same(expected, everything(folder_ / "replaced", steps));
}

} // namespace
} // namespace drogue::test
