// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/fluid_solver/box.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/fluid_case.hpp"
#include "tests/verification/fluid_meshes.hpp"

/// Steady flows in three dimensions: a sphere at Re 100 (Johnson and Patel 1999, C_D = 1.087), and the
/// cylinder in a duct of the DFG benchmark 3D-1Z (Re 20; C_D = 6.18533). Symmetric: a quarter of the sphere,
/// half of the duct.
namespace drogue::fluid::test {
namespace {

using drogue::test::verify_relative;

void verify_sphere(const std::string& name, int n, double first, double tolerance) {
  Settings s = flow_settings(0.01, 1e-3);
  s.linear = {1e-3, 400, 100};
  s.boundaries = {boundary("sphere", Condition::no_slip), velocity("inflow", "1", "0", "0"),
                  boundary("outflow", Condition::traction_free), boundary("symmetry_y", Condition::free_slip),
                  boundary("symmetry_z", Condition::free_slip)};
  s.initial_velocity = vector_expression("1", "0", "0");
  s.forces = {{"sphere", {"sphere"}, 0}};
  FlowCase flow(s, sphere_mesh(0.5, 25, n, first));
  const SurfaceForce force = flow.settle(0.5, 1e-4).front();
  fmt::print("{}: {} nodes\n", name, flow.mesh().node_count());
  const double scale = 4 / (0.5 * std::numbers::pi * 0.25); // four quarters
  verify_relative(name, "C_D", scale * force.reaction[0], 1.087, tolerance);
  verify_relative(name, "C_D_by_stress", scale * force.total()[0], 1.087, 3 * tolerance);
}

#ifdef DROGUE_FINE
void verify_duct(const std::string& name, double wall, double bulk, int layers, double tolerance) {
  constexpr double height = 0.41;
  const Channel channel{{0, 0}, {2.5, height}, {0.5, 0.2}, 0.05};
  const auto plane = channel_mesh(channel, [=](double x, double y) {
    const double distance = std::hypot(x - 0.5, y - 0.2) - 0.05;
    const double beside_wake = x > 0.5 ? std::max(std::abs(y - 0.2) - 0.06, 0.12 * (x - 0.6)) : 1.0;
    return std::min(graded(distance, wall, 0.12, bulk), graded(beside_wake, 0.5 * bulk, 0.2, bulk));
  });
  std::vector<double> z; // finer at the wall
  for (int k = 0; k <= layers; ++k)
    z.push_back(0.5 * height * (1 - std::cos(0.5 * std::numbers::pi * k / layers)));
  Settings s = flow_settings(1e-3, 1e-3);
  s.linear = {1e-3, 400, 100};
  const std::string inflow = fmt::format("16*0.45*y*z*({0}-y)*({0}-z)/{0}^4", height);
  s.boundaries = {velocity("inflow", inflow, "0", "0"),         boundary("bottom", Condition::no_slip),
                  boundary("top", Condition::no_slip),          boundary("obstacle", Condition::no_slip),
                  boundary("z0", Condition::no_slip),           boundary("z1", Condition::free_slip),
                  boundary("outflow", Condition::traction_free)};
  s.initial_velocity = vector_expression(inflow, "0", "0");
  s.forces = {{"obstacle", {"obstacle"}, 0}};
  FlowCase flow(s, extruded(plane, z));
  const SurfaceForce force = flow.settle(0.2, 1e-4).front();
  fmt::print("{}: {} nodes\n", name, flow.mesh().node_count());
  const double scale = 2 * 2 / (0.2 * 0.2 * 0.1 * height); // two halves
  verify_relative(name, "C_D", scale * force.reaction[0], 6.18533, tolerance);
  verify_relative(name, "C_D_by_stress", scale * force.total()[0], 6.18533, 3 * tolerance);
}

TEST(Sphere, Re100) {
  verify_sphere("fluid/sphere_re100_14k", 16, 0.02, 0.04);
  verify_sphere("fluid/sphere_re100", 24, 0.012, 0.02);
}
TEST(Duct, SteadyFlowRoundACylinder) {
  verify_duct("fluid/dfg_3d1z_coarse", 0.006, 0.05, 8, 0.03);
  verify_duct("fluid/dfg_3d1z", 0.003, 0.03, 14, 0.01);
}
#else
TEST(Sphere, Re100) {
  verify_sphere("fluid/sphere_re100_coarse", 8, 0.04, 0.1);
}
#endif

} // namespace
} // namespace drogue::fluid::test
