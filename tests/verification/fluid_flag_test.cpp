// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "tests/fluid_solver/box.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/fluid_case.hpp"
#include "tests/verification/fluid_meshes.hpp"

/// Flow round a cylinder with a rigid flag in a channel: CFD1 to CFD3 of Turek and Hron (2006), forces per
/// unit depth on cylinder and flag; reference values of the FeatFlow group's finest level.
namespace drogue::fluid::test {
namespace {

using drogue::test::verify;
using drogue::test::verify_relative;

/// Density 1000, kinematic viscosity 1e-3.
Settings flag_settings(double mean_speed) {
  Settings s = flow_settings(1, 1e-4);
  s.density = 1000;
  const std::string inflow = fmt::format("{}*4*y*(0.41-y)/0.1681", 1.5 * mean_speed);
  s.boundaries = {velocity("inflow", inflow, "0", "0"), boundary("bottom", Condition::no_slip),
                  boundary("top", Condition::no_slip), boundary("obstacle", Condition::no_slip),
                  boundary("outflow", Condition::traction_free)};
  s.initial_velocity = vector_expression(inflow, "0", "0");
  s.forces = {{"obstacle", {"obstacle"}, 0}};
  return s;
}

struct Reference {
  double mean_speed = 0;
  double drag = 0;
  double lift = 0;
};
#ifdef DROGUE_FINE
constexpr FlagSizes steady_sizes{0.0007, 0.07, 0.012};
constexpr double tolerance = 0.01;
const std::string level;
#else
constexpr FlagSizes steady_sizes{0.003, 0.12, 0.03};
constexpr double tolerance = 0.03;
const std::string level = "_coarse";
#endif

void verify_steady(const std::string& name, const Reference& reference) {
  FlowCase flow(flag_settings(reference.mean_speed), flag_in_channel(steady_sizes, false));
  fmt::print("{}: {} nodes\n", name, flow.mesh().node_count());
  const SurfaceForce force = flow.settle(0.1, 1e-6).front();
  verify_relative(name + level, "drag", force.reaction[0], reference.drag, tolerance);
  verify_relative(name + level, "drag_by_stress", force.total()[0], reference.drag, 2 * tolerance);
  verify_relative(name + level, "lift", force.reaction[1], reference.lift, tolerance);
}

TEST(Flag, Cfd1) {
  verify_steady("fluid/cfd1", {0.2, 14.2929, 1.11905});
}

#ifdef DROGUE_FINE
TEST(Flag, Cfd2) {
  verify_steady("fluid/cfd2", {1, 136.700, 10.5343});
}

TEST(Flag, Cfd3) {
  Settings s = flag_settings(2);
  s.initial_velocity[1] = config::Expression::parse("exp(-200*((x-0.7)^2+(y-0.2)^2))").value();
  FlowCase flow(s, flag_in_channel({0.002, 0.12, 0.022}, false));
  fmt::print("fluid/cfd3: {} nodes\n", flow.mesh().node_count());
  (void)advance(flow, semi_discrete, 0.005, 500);
  constexpr double dt = 0.0025;
  const ForceHistory force = advance(flow, semi_discrete, dt, 360);
  const Periodic drag = last_periods(force.reaction[0], force.reaction[1], dt);
  const Periodic lift = last_periods(force.reaction[1], force.reaction[1], dt);
  verify_relative("fluid/cfd3", "drag_mean", drag.mean, 439.45, 0.01);
  verify_relative("fluid/cfd3", "drag_amplitude", drag.amplitude, 5.6183, 0.03);
  verify("fluid/cfd3", "lift_mean", lift.mean, -11.893, 0.01 * 437.81);
  verify_relative("fluid/cfd3", "lift_amplitude", lift.amplitude, 437.81, 0.03);
  verify_relative("fluid/cfd3", "frequency", 1 / lift.period, 4.3956, 0.01);
}
#endif

} // namespace
} // namespace drogue::fluid::test
