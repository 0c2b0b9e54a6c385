// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "tests/fluid_solver/box.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/fluid_case.hpp"
#include "tests/verification/fluid_meshes.hpp"

/// Flow round a cylinder in a channel, Schaefer and Turek, DFG benchmarks 2D-1 (Re 20, steady) and 2D-2 (Re
/// 100, periodic); reference values of the FeatFlow group. Forces by the nodal reaction and by the stress on
/// the surface.
namespace drogue::fluid::test {
namespace {

using drogue::test::verify_between;
using drogue::test::verify_relative;

constexpr double diameter = 0.1;

struct Sizes {
  double wall = 0;   ///< edge length on the cylinder
  double growth = 0; ///< of edges with the distance
  double bulk = 0;   ///< the longest edge; in the wake 0.4 of it
};

mesh::Mesh cylinder_in_channel(const Sizes& sizes) {
  const Channel channel{{0, 0}, {2.2, 0.41}, {0.2, 0.2}, 0.5 * diameter};
  return channel_mesh(channel, [sizes](double x, double y) {
    const double distance = std::hypot(x - 0.2, y - 0.2) - 0.5 * diameter;
    const double beside_wake = x > 0.2 ? std::max(std::abs(y - 0.2) - 0.06, 0.12 * (x - 0.3)) : 1.0;
    return std::min(graded(distance, sizes.wall, sizes.growth, sizes.bulk),
                    graded(beside_wake, 0.4 * sizes.bulk, 0.2, sizes.bulk));
  });
}

Settings channel_settings(double largest_speed, double residual_tolerance) {
  Settings s = flow_settings(1e-3, residual_tolerance);
  const std::string inflow = fmt::format("{}*y*(0.41-y)/0.1681", 4 * largest_speed);
  s.boundaries = {velocity("inflow", inflow, "0", "0"), boundary("bottom", Condition::no_slip),
                  boundary("top", Condition::no_slip), boundary("obstacle", Condition::no_slip),
                  boundary("outflow", Condition::traction_free)};
  s.initial_velocity = vector_expression(inflow, "0", "0");
  s.forces = {{"obstacle", {"obstacle"}, 0}};
  return s;
}

/// 2 F / (rho U^2 D), U two thirds of the largest speed.
double coefficient(double force, double largest_speed) {
  const double mean = 2 * largest_speed / 3;
  return 2 * force / (mean * mean * diameter);
}

double pressure_difference(const FlowCase& flow) {
  return value_at(flow, 0.15, 0.2)[3] - value_at(flow, 0.25, 0.2)[3];
}

/// Relative tolerances; C_L: 0 where it is not compared.
struct Tolerances {
  double drag = 0;
  double drag_by_stress = 0;
  double lift = 0;
  double pressure = 0;
};

void verify_steady(const std::string& name, const Sizes& sizes, const Tolerances& tolerances) {
  FlowCase flow(channel_settings(0.3, 1e-4), cylinder_in_channel(sizes));
  const SurfaceForce force = flow.settle(0.1).front();
  fmt::print("{}: {} nodes\n", name, flow.mesh().node_count());
  verify_relative(name, "C_D", coefficient(force.reaction[0], 0.3), 5.57953523384, tolerances.drag);
  verify_relative(name, "C_D_by_stress", coefficient(force.total()[0], 0.3), 5.57953523384,
                  tolerances.drag_by_stress);
  verify_relative(name, "dp", pressure_difference(flow), 0.11752016697, tolerances.pressure);
  if (tolerances.lift > 0)
    verify_relative(name, "C_L", coefficient(force.reaction[1], 0.3), 0.010618948146, tolerances.lift);
}

#ifdef DROGUE_FINE
TEST(Channel, Steady) {
  verify_steady("fluid/dfg_2d1_8k", {0.001, 0.1, 0.02}, {0.01, 0.02, 0.2, 0.02});
  verify_steady("fluid/dfg_2d1_22k", {0.0005, 0.08, 0.01}, {0.005, 0.01, 0.05, 0.01});
  verify_steady("fluid/dfg_2d1_35k", {0.0004, 0.07, 0.008}, {0.005, 0.01, 0.05, 0.005});
}

/// Coefficients of the last cycles. FeatFlow's finest level; C_L max: the interval of 1996.
void verify_periodic(const std::string& name, const Sizes& sizes, const StepScheme& scheme, double dt,
                     const Tolerances& tolerances, double frequency_tolerance) {
  Settings s = channel_settings(1.5, 1e-4);
  s.initial_velocity[1] = config::Expression::parse("0.5*exp(-200*((x-0.35)^2+(y-0.2)^2))").value();
  FlowCase flow(s, cylinder_in_channel(sizes));
  fmt::print("{}: {} nodes\n", name, flow.mesh().node_count());
  (void)advance(flow, semi_discrete, 0.01, 250);
  (void)advance(flow, semi_discrete, 0.0033, 200);
  const ForceHistory force = advance(flow, scheme, dt, static_cast<int>(1.4 / dt));
  const Periodic drag = last_periods(force.reaction[0], force.reaction[1], dt);
  const Periodic lift = last_periods(force.reaction[1], force.reaction[1], dt);
  const Periodic drag_by_stress = last_periods(force.stress[0], force.reaction[1], dt);
  const Periodic lift_by_stress = last_periods(force.stress[1], force.reaction[1], dt);
  verify_relative(name, "C_D_max", coefficient(drag.largest, 1.5), 3.227393, tolerances.drag);
  verify_relative(name, "C_D_max_by_stress", coefficient(drag_by_stress.largest, 1.5), 3.227393,
                  tolerances.drag_by_stress);
  verify_relative(name, "C_L_max", coefficient(lift.largest, 1.5), 1.0, tolerances.lift);
  verify_relative(name, "C_L_range", coefficient(2 * lift.amplitude, 1.5), 2.007871, tolerances.lift);
  verify_relative(name, "C_L_range_by_stress", coefficient(2 * lift_by_stress.amplitude, 1.5), 2.007871,
                  3 * tolerances.lift);
  verify_relative(name, "St", diameter / lift.period, 0.301841, frequency_tolerance);
}

TEST(Channel, Periodic) {
  verify_periodic("fluid/dfg_2d2_4k", {0.002, 0.1, 0.03}, semi_discrete, 0.00166, {0.03, 0.06, 0.06, 0},
                  0.02);
  verify_periodic("fluid/dfg_2d2_12k", {0.001, 0.08, 0.015}, semi_discrete, 0.00166, {0.01, 0.03, 0.02, 0},
                  0.01);
}
TEST(Channel, PeriodicSpaceTime) {
  verify_periodic("fluid/dfg_2d2_4k_dsd_sst", {0.002, 0.1, 0.03}, space_time, 0.005, {0.03, 0.06, 0.06, 0},
                  0.02);
}
#else
TEST(Channel, Steady) {
  verify_steady("fluid/dfg_2d1_2k", {0.004, 0.09, 0.05}, {0.01, 0.04, 0, 0.05});
}
#endif

} // namespace
} // namespace drogue::fluid::test
