// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "common/mesh/msh.hpp"
#include "fluid_solver/flow_fields.hpp"
#include "tests/fluid_solver/box.hpp"
#include "tests/support/t10_fluid.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/fluid_case.hpp"

/// The flow round the rigid, inflated T-10 at the paper's size from an impulsive start: 22 ft/s everywhere
/// but on the cloth, at Re = 5e6 with Smagorinsky's model; 100 space-time slabs of the paper's step. Feet,
/// slugs, seconds. DROGUE_T10_MESH=FILE in the environment puts another mesh in the place of ours: one in
/// metres with the same names of boundaries.
namespace drogue::fluid::test {
namespace {

using drogue::test::verify;
using drogue::test::verify_between;

constexpr double speed = 22;
constexpr double constructed_area = 1298.9;
constexpr int steps = 100;

Result<mesh::Mesh> mesh_of_the_case(const char* file) {
  if (file == nullptr) return drogue::test::t10_fluid_mesh(drogue::test::t10_fluid_paper);
  auto mesh = mesh::read_msh(file);
  if (mesh)
    for (double& x : mesh->points) x /= 0.3048;
  return mesh;
}

TEST(T10, AHundredStepsFromAnImpulsiveStart) {
  const char* const file = std::getenv("DROGUE_T10_MESH");
  auto made = mesh_of_the_case(file);
  ASSERT_TRUE(made.ok()) << made.error().message;
  Settings s = flow_settings(3.66058e-7, 1e-2);
  s.density = 0.002377;
  s.smagorinsky = 0.1;
  s.newton.max_iterations = 10;
  s.linear = {1e-2, 300, 60};
  s.boundaries = {velocity("inflow", "0", "0", "22"), boundary("outflow", Condition::traction_free),
                  boundary("side", Condition::free_slip), boundary("canopy_upper", Condition::no_slip),
                  boundary("canopy_lower", Condition::no_slip)};
  s.boundaries[1].backflow = 0.5;
  s.initial_velocity = vector_expression("0", "0", "22");
  s.forces = {{"canopy", {"canopy_upper", "canopy_lower"}, 0}};
  const double unit = 0.5 * s.density * speed * speed * constructed_area;
  FlowCase flow(s, std::move(*made));
  fmt::print("{} nodes, {} tetrahedra\n", flow.mesh().node_count(), flow.mesh().cell_count());

  double cfl = 0;
  std::vector<double> drag;
  while (drag.size() < steps && !HasFailure()) {
    drag.push_back(flow.step(space_time, 0.0032).front().reaction[2] / unit);
    cfl = std::max(cfl, largest_cfl(flow.mesh(), flow.state().x, flow.state().u, 0.0032));
    fmt::print("step {} drag {:.4f} cfl {:.2f}\n", drag.size(), drag.back(), cfl);
    std::fflush(stdout);
  }
  const std::string name =
      file == nullptr ? "fluid/t10_impulsive_start" : "fluid/t10_impulsive_start_given_mesh";
  verify(name, "steps_done", static_cast<double>(flow.state().step), steps, 0);
  verify_between(name, "largest_cfl", cfl, 0, 10);
  // the first slabs hold the impulse, 234 in the first, -97 in the second
  constexpr int impulse = 20;
  ASSERT_GT(drag.size(), static_cast<std::size_t>(impulse));
  const auto [least, largest] = std::minmax_element(drag.begin() + impulse, drag.end());
  verify_between(name, "least_C_D_after_20", *least, 0, 1);
  verify_between(name, "largest_C_D_after_20", *largest, 0, 1);
}

} // namespace
} // namespace drogue::fluid::test
