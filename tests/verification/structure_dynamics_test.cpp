// SPDX-License-Identifier: GPL-3.0-or-later
//
// Motion of structures against exact solutions: a pendulum on a stiff cable, the same while its cable is
// drawn in slowly, a payload that falls through air, and what every time integration keeps of a parachute in
// free flight.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include <unistd.h>

#include <gtest/gtest.h>

#include "parachute_mesher/commands.hpp"
#include "structure_solver/case.hpp"
#include "tests/structure_solver/test_structures.hpp"
#include "tests/support/verify.hpp"

namespace drogue::structure {
namespace {

using drogue::test::verify;
using drogue::test::verify_relative;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double g = 9.81;

void advance(Integrator& integrator, double dt) {
  integrator.begin_step(dt, Integrator::Predictor::extrapolate);
  const auto outcome = integrator.iterate_to_tolerance();
  ASSERT_TRUE(outcome) << outcome.error().message;
  ASSERT_TRUE(outcome->converged) << "t = " << integrator.trial().time;
  integrator.commit();
}

/// A weight on a massless cable of length 1, at rest under an angle to the vertical.
Settings pendulum_settings() {
  Settings s;
  s.cables = {{"line", {1e-4, 0.0, 1e9, 0, StrainMeasure::green, true}, {}}};
  s.masses = {{"last", 1.0}};
  s.supports = {{"first", {true, true, true}, {}}};
  s.ignored_groups = {"middle"};
  s.gravity = test::vector("0", "0", "-9.81");
  return s;
}
Model pendulum(const Settings& settings, double angle) {
  return test::model(settings, test::chain(1, {0, 0, 0}, {std::sin(angle), 0, -std::cos(angle)}));
}
double angle_of(const Model& model, const State& state) {
  return std::atan2(model.mesh.points[3] + state.u[3], -(model.mesh.points[5] + state.u[5]));
}

/// Mean of the first two periods, from the times at which the angle passes zero.
double period(double release) {
  const Model model = pendulum(pendulum_settings(), release);
  Integrator integrator(model, {0.9, 0.0, {.displacement_tolerance = 1e-11}}, rest_state(model));
  integrator.balance_start();
  const double dt = 2e-3;
  std::vector<double> passages;
  double before = release;
  while (passages.size() < 5 && integrator.committed().time < 30) {
    advance(integrator, dt);
    const double now = angle_of(model, integrator.committed());
    if (before * now < 0) passages.push_back(integrator.committed().time - dt * now / (now - before));
    before = now;
  }
  return passages.size() == 5 ? (passages[4] - passages[0]) / 2 : 0;
}

TEST(Pendulum, PeriodOnAStiffCable) {
  const double T0 = 2 * pi * std::sqrt(1 / g);
  verify_relative("structure/pendulum", "period_30_deg", period(pi / 6) / T0, 1.017409, 1e-3);
  verify_relative("structure/pendulum", "period_60_deg", period(pi / 3) / T0, 1.073182, 1e-3);
}

/// Slow change of the length keeps E / omega: the amplitude goes as L^(-3/4).
TEST(Pendulum, AmplitudeWhileTheCableIsDrawnIn) {
  const double release = 0.05, shortest = 0.5, begin = 5, end = 85;
  Settings s = pendulum_settings();
  s.natural_lengths = {{"line", {{{begin, 1}, {end, shortest}}, true, test::expression("1")}}};
  const Model model = pendulum(s, release);
  Integrator integrator(model, {0.9, 0.0, {.displacement_tolerance = 1e-11}}, rest_state(model));
  integrator.balance_start();
  double before = 0, after = 0, energy = 0;
  const double dt = 4e-3;
  while (integrator.committed().time < end + 5) {
    advance(integrator, dt);
    const double t = integrator.committed().time, angle = std::abs(angle_of(model, integrator.committed()));
    if (t < begin) before = std::max(before, angle);
    if (t > end) after = std::max(after, angle);
  }
  const Balance b = integrator.balance();
  energy = b.kinetic_energy + b.strain_energy;
  verify_relative("structure/pendulum_drawn_in", "amplitude_ratio", after / before, std::pow(shortest, -0.75),
                  1e-2);
  // the actuator lifts the weight and speeds it up; external work is that of gravity
  verify_relative("structure/pendulum_drawn_in", "actuator_work", b.ledger.actuator,
                  energy - *b.ledger.start - b.ledger.external, 1e-2);
}

/// m dv/dt = m g - k v^2: v = v_t tanh(g t / v_t), fallen v_t^2 / g ln cosh(g t / v_t), v_t = sqrt(m g / k).
TEST(Payload, TerminalVelocityUnderDrag) {
  Settings s;
  s.masses = {{"last", 100.0}};
  s.cables = {{"line",
               {1e-4, 100.0, 1e6, 0, StrainMeasure::green, true},
               100.0}}; // slack: a hundred metres of thread
  s.supports = {{"first", {true, true, true}, test::vector("0", "0", "0")}};
  s.ignored_groups = {"middle"};
  s.gravity = test::vector("0", "0", "-9.81");
  const double k = 0.5 * 1.225 * 0.9 * 1.5, mass = 100 + 0.5 * 1e-4 * 100 * 100;
  s.point_drag = {{"last", k, test::vector("2", "0", "0"), false}};
  const Model model = test::model(s, test::chain(1, {0, 0, 0}, {0, 0, -1}));
  State start = rest_state(model);
  start.v[3] = 2; // drifts with the wind
  Integrator integrator(model, {0.8, 0.0, {.displacement_tolerance = 1e-12}}, std::move(start));
  integrator.balance_start();
  const double terminal = std::sqrt(mass * g / k), dt = 0.01;
  while (integrator.committed().time < 3 - 0.5 * dt) advance(integrator, dt);
  const State& state = integrator.committed();
  const double tau = g * state.time / terminal;
  verify_relative("structure/payload_drag", "velocity", -state.v[5], terminal * std::tanh(tau), 1e-5);
  verify_relative("structure/payload_drag", "fallen", -state.u[5],
                  terminal * terminal / g * std::log(std::cosh(tau)), 1e-5);
  verify_relative("structure/payload_drag", "drift", state.u[3], 2 * state.time, 1e-9);
}

struct Momentum {
  Vector3d linear = Vector3d::Zero();
  Vector3d angular = Vector3d::Zero(); ///< about the centre of mass
};
Momentum momentum(const Model& model, const State& state) {
  Momentum p;
  Vector3d centre = Vector3d::Zero();
  double mass = 0;
  const auto at = [](const std::vector<double>& values, std::size_t i) { return Vector3d(&values[3 * i]); };
  for (std::size_t i = 0; i < model.node_count(); ++i) {
    mass += model.mass[i];
    centre += model.mass[i] * (at(model.mesh.points, i) + at(state.u, i));
    p.linear += model.mass[i] * at(state.v, i);
  }
  centre /= mass;
  for (std::size_t i = 0; i < model.node_count(); ++i)
    p.angular += model.mass[i] *
                 (at(model.mesh.points, i) + at(state.u, i) - centre).cross(at(state.v, i) - p.linear / mass);
  return p;
}

/// A small unloaded parachute that spins and drifts, from files.
class FreeFlight : public testing::Test {
 protected:
  void SetUp() override {
    previous_ = std::filesystem::current_path();
    folder_ = std::filesystem::temp_directory_path() / ("drogue-free-flight-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    std::filesystem::current_path(folder_);
    std::ofstream("parachute.textproto") << R"(
      canopy { diameter: 35 vent_ratio: 0.1 skirt_ratio: 0.1 gores: 12 }
      rigging { line_length: 29.4 line_elements: 4 vent_elements: 2 confluence_distance: 2.3 }
      structure { file: "structure.msh" element: Q9 main_rows: 4 skirt_rows: 1 across_vent: 1 across_seam: 1 across_skirt: 1 }
    )";
    const auto meshed = parachute::write_structure_mesh("parachute.textproto");
    ASSERT_TRUE(meshed) << meshed.error().message;
  }
  void TearDown() override {
    std::filesystem::current_path(previous_);
    std::filesystem::remove_all(folder_);
  }

  static void fly(const std::string& name, const std::string& scheme, double angular_drift,
                  double energy_drift) {
    std::ofstream("free.textproto") << R"(
      mesh: "structure.msh"
      membrane { group: "canopy" thickness: 0.0001 density: 6.0 youngs_modulus: 2.0e5 poisson_ratio: 0.3 }
      cable { group: "suspension_lines" area: 0.0001 density: 6.0 youngs_modulus: 4.32e6 }
      cable { group: "radials" area: 0.0001 density: 6.0 youngs_modulus: 4.32e6 }
      cable { group: "vent_lines" area: 0.0001 density: 6.0 youngs_modulus: 4.32e6 }
      initial_velocity { x: "5 - 0.8*y" y: "0.8*x" z: "-2" }
      newton { displacement_tolerance: 1e-9 max_iterations: 30 }
      time { step: 0.02 steps: 50 )" << scheme
                                    << " }\n";
    const auto c = load_case("free.textproto");
    ASSERT_TRUE(c) << c.error().message;
    Integrator integrator(*c->model, c->integrator_options(), c->start);
    integrator.balance_start();
    const Momentum before = momentum(*c->model, integrator.committed());
    for (int k = 0; k < c->settings.time.steps; ++k) advance(integrator, c->settings.time.step);
    const Momentum after = momentum(*c->model, integrator.committed());
    const Balance b = integrator.balance();
    const std::string test = "structure/free_flight_" + name;
    verify(test, "linear_momentum_drift", (after.linear - before.linear).norm() / before.linear.norm(), 0,
           1e-12);
    verify(test, "angular_momentum_drift", (after.angular - before.angular).norm() / before.angular.norm(), 0,
           angular_drift);
    verify(test, "energy_drift", (b.kinetic_energy + b.strain_energy) / *b.ledger.start - 1, 0, energy_drift);
  }

 private:
  std::filesystem::path previous_, folder_;
};

TEST_F(FreeFlight, WhatEveryIntegrationKeeps) {
  fly("rho_1", "rho_infinity: 1", 1e-12, 1e-3); // the midpoint rule keeps angular momentum
  fly("rho_0.8", "rho_infinity: 0.8", 1e-4, 1e-3);
  fly("rho_0.5", "rho_infinity: 0.5", 1e-4, 1e-3);
  fly("rho_0", "rho_infinity: 0", 2e-3, 5e-3);
  fly("hht_0.1", "scheme: HHT hht_alpha: -0.1", 1e-4, 1e-3);
  fly("newmark", "scheme: NEWMARK", 1e-4, 1e-3);
}

} // namespace
} // namespace drogue::structure
