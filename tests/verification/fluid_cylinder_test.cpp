// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "tests/fluid_solver/box.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/fluid_case.hpp"
#include "tests/verification/fluid_meshes.hpp"

/// A cylinder in a wide stream, diameter 1, speed 1: the intervals in which published drag, lift and
/// frequency lie, widened by 2 % for the finite domain.
namespace drogue::fluid::test {
namespace {

using drogue::test::verify_between;

struct Interval {
  double low = 0;
  double high = 0;
};

void verify_in(const std::string& name, const std::string& quantity, double value, const Interval& interval) {
  verify_between(name, quantity, value, 0.98 * interval.low, 1.02 * interval.high);
}

mesh::Mesh wide_domain(double wall) {
  const Channel channel{{-20, -25}, {40, 25}, {0, 0}, 0.5};
  return channel_mesh(channel, [wall](double x, double y) {
    const double distance = std::hypot(x, y) - 0.5;
    const double beside_wake = x > 0 ? std::max(std::abs(y) - 1.0, 0.1 * (x - 12)) : 30.0;
    return std::min(graded(distance, wall, 0.12, 4), graded(beside_wake, 0.2, 0.2, 4));
  });
}

Settings stream(double reynolds) {
  Settings s = flow_settings(1 / reynolds, 1e-4);
  s.boundaries = {velocity("inflow", "1", "0", "0"), boundary("bottom", Condition::free_slip),
                  boundary("top", Condition::free_slip), boundary("obstacle", Condition::no_slip),
                  boundary("outflow", Condition::traction_free)};
  s.initial_velocity = vector_expression("1", "0.5*exp(-((x-2)^2+y^2))", "0");
  s.forces = {{"obstacle", {"obstacle"}, 0}};
  return s;
}

#ifdef DROGUE_FINE
void verify_shedding(const std::string& name, double reynolds, double dt, const Interval& drag,
                     const Interval& lift, const Interval& strouhal) {
  FlowCase flow(stream(reynolds), wide_domain(0.02));
  fmt::print("{}: {} nodes\n", name, flow.mesh().node_count());
  (void)advance(flow, semi_discrete, 0.12, 600);
  const ForceHistory force = advance(flow, semi_discrete, dt, static_cast<int>(28 / dt));
  const Periodic c_d = last_periods(force.reaction[0], force.reaction[1], dt);
  const Periodic c_l = last_periods(force.reaction[1], force.reaction[1], dt);
  verify_in(name, "C_D_mean", 2 * c_d.average, drag);
  verify_in(name, "C_L_amplitude", 2 * c_l.amplitude, lift);
  verify_in(name, "St", 1 / c_l.period, strouhal);
}

TEST(Cylinder, Re100) {
  verify_shedding("fluid/cylinder_re100", 100, 0.05, {1.33, 1.35}, {0.32, 0.34}, {0.164, 0.166});
}
TEST(Cylinder, Re200) {
  verify_shedding("fluid/cylinder_re200", 200, 0.04, {1.31, 1.34}, {0.65, 0.70}, {0.19, 0.20});
}
#else
TEST(Cylinder, Re20) {
  FlowCase flow(stream(20), wide_domain(0.05));
  verify_in("fluid/cylinder_re20", "C_D", 2 * flow.settle(0.2, 1e-5).front().reaction[0], {2.00, 2.05});
}
TEST(Cylinder, Re40) {
  FlowCase flow(stream(40), wide_domain(0.05));
  verify_in("fluid/cylinder_re40", "C_D", 2 * flow.settle(0.2, 1e-5).front().reaction[0], {1.50, 1.54});
}
#endif

} // namespace
} // namespace drogue::fluid::test
