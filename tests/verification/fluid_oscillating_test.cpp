// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/fluid_solver/box.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/fluid_case.hpp"
#include "tests/verification/fluid_meshes.hpp"

/// A cylinder that oscillates in line in a fluid at rest, Re 100, KC 5 (the set-up of Duetsch et al. 1998):
/// x = -A sin(2 pi f t), KC = U/(f D), U = 2 pi f A. The mesh follows as a whole, or deforms between the
/// cylinder and a far boundary at rest: the two force histories must agree. The flow is symmetric, the mesh
/// its upper half.
namespace drogue::fluid::test {
namespace {

using drogue::test::verify;

constexpr double pi = std::numbers::pi;
constexpr double radius = 0.5;
constexpr double far_radius = 40;
constexpr double speed = 1;
constexpr double period = 5; ///< KC D / U
constexpr double amplitude = speed * period / (2 * pi);

#ifdef DROGUE_FINE
constexpr int around = 64;
constexpr int steps_a_period = 100;
constexpr int steps = 150;
const std::string level = "_fine";
#else
constexpr int around = 24;
constexpr int steps_a_period = 50;
constexpr int steps = 30;
const std::string level;
#endif

/// Part of the cylinder's displacement that a point takes.
using Share = double (*)(double distance_from_axis);
double whole(double) {
  return 1;
}
/// 1 up to two diameters, 0 from 20 on, smooth between.
double deforming(double distance) {
  const double s = std::clamp((20 - distance) / 18, 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

/// Force on the upper half in the direction of the motion, mean of every step.
std::vector<double> force_history(Share share) {
  Settings s = flow_settings(0.01, 1e-4); // U D / nu = 100
  s.boundaries = {boundary("cylinder", Condition::no_slip), velocity("outer", "0", "0", "0"),
                  boundary("symmetry", Condition::free_slip)};
  s.forces = {{"cylinder", {"cylinder"}, 0}};
  FlowCase flow(s, ring_mesh(radius, far_radius, around, 0.5 * pi / around, true));
  const std::vector<double>& start = flow.mesh().points;
  const double dt = period / steps_a_period;
  const auto at = [&](double t) { return -amplitude * std::sin(2 * pi * t / period); };
  std::vector<double> history;
  for (int k = 0; k < steps; ++k) {
    std::vector<double> x = start;
    std::vector<double> wall_n(x.size(), 0.0);
    const double t_n = k * dt;
    const double t_np1 = (k + 1) * dt;
    for (std::size_t i = 0; i < x.size(); i += 3) {
      x[i] += share(std::hypot(start[i], start[i + 1])) * at(t_np1);
      wall_n[i] = (at(t_np1) - at(t_n)) / dt; // of the chord: the wall is where the slab has it
    }
    history.push_back(flow.step_to(space_time, dt, x, wall_n, wall_n).front().reaction[0]);
  }
  return history;
}

TEST(OscillatingCylinder, ForcesAgreeOnRigidAndDeformingMesh) {
  const std::vector<double> rigid = force_history(whole);
  const std::vector<double> deformed = force_history(deforming);
  double largest = 0, difference = 0;
  for (std::size_t k = 2; k < rigid.size(); ++k) { // the first steps hold the impulse of the start
    largest = std::max(largest, std::abs(rigid[k]));
    difference = std::max(difference, std::abs(rigid[k] - deformed[k]));
  }
  fmt::print("largest C_D {}\n", 2 * largest / (0.5 * speed * speed * 2 * radius));
  verify("fluid/oscillating_cylinder" + level, "force_difference", difference / largest, 0, 0.01);
}

} // namespace
} // namespace drogue::fluid::test
