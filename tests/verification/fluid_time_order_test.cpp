// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/fluid_solver/box.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/fluid_case.hpp"

/// Observed orders in time alone: vortices that decay in a frictionless square, on one mesh, against the same
/// with a much smaller step. All begin from a state that some steps have made consistent with the discrete
/// equations.
namespace drogue::fluid::test {
namespace {

using drogue::test::verify_between;

constexpr double duration = 1;
constexpr int reference_steps = 192;

Settings vortices(double viscosity = 0.2) {
  Settings s = flow_settings(viscosity, 1e-9);
  for (const char* side : {"x0", "x1", "y0", "y1"})
    s.boundaries.push_back(boundary(side, Condition::free_slip));
  // stream function sin x sin y + 0.4 sin 2x sin y
  s.initial_velocity =
      vector_expression("sin(x)*cos(y)+0.4*sin(2*x)*cos(y)", "-cos(x)*sin(y)-0.8*cos(2*x)*sin(y)", "0");
  return s;
}

io::State state_after(const Settings& settings, const StepScheme& scheme, const io::State* start, double time,
                      int steps) {
  FlowCase flow(settings, rectangle_mesh({20, 20}, {std::numbers::pi, std::numbers::pi}, true));
  if (start != nullptr) {
    EXPECT_TRUE(flow.solver().import_state(*start).ok());
  }
  for (int k = 0; k < steps; ++k) flow.step(scheme, time / steps);
  return flow.solver().export_state();
}

double difference(const io::State& a, const io::State& b) {
  double square = 0;
  const auto& u = a.find("velocity")->values;
  const auto& v = b.find("velocity")->values;
  for (std::size_t i = 0; i < u.size(); ++i) square += std::pow(u[i] - v[i], 2);
  return std::sqrt(square / static_cast<double>(u.size()));
}

/// Order of the velocity at the end of the last step, between `steps` and twice as many.
double observed_order(const Settings& settings, const StepScheme& scheme, int steps) {
  Settings preparing = settings;
  preparing.tau_step = settings.tau_step.value_or(0.02);
  const io::State start = state_after(preparing, {Formulation::semi_discrete}, nullptr, 0.1, 10);
  const io::State exact = state_after(settings, scheme, &start, duration, reference_steps);
  const double coarse = difference(state_after(settings, scheme, &start, duration, steps), exact);
  const double fine = difference(state_after(settings, scheme, &start, duration, 2 * steps), exact);
  return std::log2(coarse / fine);
}

Settings tau_held(double viscosity, bool time_weight) {
  Settings s = vortices(viscosity);
  s.tau_step = 3e-4;
  s.time_weight = time_weight;
  return s;
}

/// With tau of the step's own size the limit moves with the step, and with it what is measured here.
TEST(TimeOrder, SpaceTimeWithTauOfTheStep) {
  verify_between("fluid/time_order", "dsd_sst_tau_of_the_step", observed_order(vortices(), space_time, 6),
                 0.3, 1.5);
}

/// With tau held and small against the step it is that of the linear discontinuous Galerkin method, three.
/// The time weight lets in the viscous term that linear elements leave out of the residual: there viscosity
/// must be small.
TEST(TimeOrder, SpaceTimeWithTauHeld) {
  verify_between("fluid/time_order", "dsd_sst_tau_held", observed_order(tau_held(1e-4, true), space_time, 4),
                 2.5, 3.5);
  verify_between("fluid/time_order", "dsd_sst_tau_held_no_time_weight",
                 observed_order(tau_held(1e-4, false), space_time, 8), 2.5, 3.5);
  verify_between("fluid/time_order", "dsd_sst_tau_held_no_time_weight_viscous",
                 observed_order(tau_held(0.2, false), space_time, 8), 2.5, 3.5);
}

TEST(TimeOrder, SemiDiscrete) {
  Settings s = vortices();
  s.tau_step = 0.02;
  StepScheme scheme = semi_discrete;
  verify_between("fluid/time_order", "semi_discrete_2", observed_order(s, scheme, 12), 1.8, 2.3);
  scheme.time_order = 1;
  verify_between("fluid/time_order", "semi_discrete_1", observed_order(s, scheme, 12), 0.9, 1.2);
}

} // namespace
} // namespace drogue::fluid::test
