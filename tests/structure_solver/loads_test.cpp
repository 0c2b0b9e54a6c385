// SPDX-License-Identifier: GPL-3.0-or-later
//
// Loads and lengths that change with time, moving supports, the account of energy, and what is said when a
// step fails.
#include <gtest/gtest.h>

#include "structure_solver/elements/drag.hpp"
#include "tests/structure_solver/test_structures.hpp"

namespace drogue::structure {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Largest difference between a derivative and central differences, relative to its largest entry.
template <class Force>
double derivative_error(const Matrix3d& exact, const Vector3d& at, const Force& force) {
  Matrix3d numerical;
  for (int c = 0; c < 3; ++c) {
    const Vector3d h = 1e-6 * Vector3d::Unit(c);
    numerical.col(c) = (force(at + h) - force(at - h)) / 2e-6;
  }
  return (numerical - exact).cwiseAbs().maxCoeff() / exact.cwiseAbs().maxCoeff();
}

TEST(Drag, DerivativesAndSize) {
  const Vector3d w(3, -4, 12), d(0.4, 0.1, -0.2);
  EXPECT_NEAR(PointDrag::at(0.5, w).force.norm(), 0.5 * 13 * 13, 1e-12);
  EXPECT_EQ(PointDrag::at(0.5, Vector3d::Zero()).force.norm(), 0);
  EXPECT_LT(derivative_error(PointDrag::at(0.5, w).by_wind, w,
                             [](const Vector3d& v) { return PointDrag::at(0.5, v).force; }),
            1e-8);
  for (const bool cross_flow : {false, true}) {
    const LineDrag drag = LineDrag::at(0.5, cross_flow, d, w);
    EXPECT_LT(derivative_error(drag.by_wind, w,
                               [&](const Vector3d& v) { return LineDrag::at(0.5, cross_flow, d, v).force; }),
              1e-8);
    EXPECT_LT(derivative_error(drag.by_line, d,
                               [&](const Vector3d& e) { return LineDrag::at(0.5, cross_flow, e, w).force; }),
              1e-8);
  }
  EXPECT_NEAR(LineDrag::at(0.5, true, d, w).force.dot(d), 0, 1e-13);
  EXPECT_NEAR(LineDrag::at(0.5, true, d, 7 * d).force.norm(), 0, 1e-13); // wind along the line
}

TEST(LengthSchedule, RampsSmoothlyBetweenItsPoints) {
  const LengthSchedule schedule{{{1, 1}, {3, 0.5}}, true, test::expression("1")};
  EXPECT_EQ(schedule(0), 1);
  EXPECT_EQ(schedule(4), 0.5);
  EXPECT_DOUBLE_EQ(schedule(2), 0.75);
  const double h = 1e-4;
  EXPECT_LT(1 - schedule(1 + h), 1e-10); // neither rate nor acceleration at the ends
  EXPECT_LT(schedule(3 - h) - 0.5, 1e-10);
  const LengthSchedule linear{{{1, 1}, {3, 0.5}}, false, test::expression("2*t")};
  EXPECT_DOUBLE_EQ(linear(2), 0.75 * 4);
}

/// A cable of five elements between a held point and a heavy one, pulled in and swung.
struct Swing {
  Settings settings;
  Swing() {
    settings.cables = {{"line", {1e-4, 800.0, 1e8, 0, StrainMeasure::green, true, 1e-4}, {}}};
    settings.masses = {{"last", 2.0}};
    settings.supports = {{"first", {true, true, true}, test::vector("0.1*(1-cos(3*t))", "0", "0.05*t*t")}};
    settings.ignored_groups = {"middle"};
    settings.gravity = test::vector("0", "0", "-9.81");
    settings.natural_lengths = {{"line", {{{0.1, 1}, {0.6, 0.8}}, true, test::expression("1")}}};
    settings.point_drag = {{"last", 0.05, test::vector("3", "0", "0"), false}};
    settings.line_drag = {{"line", 0.01, test::vector("3", "0", "0"), true}};
  }
  [[nodiscard]] Model model() const {
    return test::model(settings, test::chain(5, {0, 0, 0}, {0.6, 0, -0.8}));
  }
};

/// Energy that is lost over a time, relative to what went in and out; Newmark with beta = 1/4 loses none in
/// the limit.
double lost(double dt, double mass_damping, double stiffness_damping) {
  const Model model = Swing().model();
  Integrator::Options options{
      GeneralisedAlpha::newmark(0.25, 0.5), mass_damping, {.displacement_tolerance = 1e-12}};
  options.stiffness_damping = stiffness_damping;
  Integrator integrator(model, options, rest_state(model));
  integrator.balance_start();
  for (int k = 0; k < static_cast<int>(std::lround(0.8 / dt)); ++k) {
    integrator.begin_step(dt, Integrator::Predictor::extrapolate);
    const auto outcome = integrator.iterate_to_tolerance();
    EXPECT_TRUE(outcome && outcome->converged);
    integrator.commit();
  }
  const Balance b = integrator.balance();
  EXPECT_GT(b.ledger.actuator, 0.5); // lifting 2 kg by 0.2 m, and more
  EXPECT_GT(std::abs(b.ledger.support), 0.1);
  EXPECT_GE(b.ledger.damping, mass_damping > 0 ? 0.05 : 0.0);
  return std::abs(b.energy_lost) / (std::abs(b.ledger.external) + std::abs(b.ledger.actuator));
}

TEST(Energy, EveryPathIsInTheAccount) {
  EXPECT_LT(lost(5e-4, 0, 0), 2e-3);
  EXPECT_LT(lost(5e-4, 0.5, 1e-4), 2e-3);
}

TEST(Support, MovesWithTheDerivativesOfItsExpression) {
  const Model model = Swing().model();
  Integrator integrator(model, {0.5, 0.0, {}}, rest_state(model));
  for (int k = 0; k < 10; ++k) {
    integrator.begin_step(0.01, Integrator::Predictor::extrapolate);
    ASSERT_TRUE(integrator.iterate_to_tolerance());
    integrator.commit();
  }
  const State& s = integrator.committed();
  const double t = s.time;
  EXPECT_NEAR(s.u[0], 0.1 * (1 - std::cos(3 * t)), 1e-15);
  EXPECT_NEAR(s.v[0], 0.3 * std::sin(3 * t), 1e-9);
  EXPECT_NEAR(s.a[0], 0.9 * std::cos(3 * t), 1e-7);
  EXPECT_NEAR(s.v[2], 0.1 * t, 1e-9);
  EXPECT_NEAR(s.a[2], 0.1, 1e-7);
  EXPECT_EQ(s.v[1], 0);
}

/// A hanging weight on a shortened cable: T = EA (l - L)/L in engineering strain, with Newton statics.
TEST(Statics, NewtonFindsTheShortenedCable) {
  Settings s;
  s.cables = {{"line", {1e-4, 0.0, 1e6, 0, StrainMeasure::engineering, true}, {}}};
  s.masses = {{"last", 2.0}};
  s.supports = {{"first", {true, true, true}, {}}, {"last", {true, true, false}, {}}};
  s.ignored_groups = {"middle"};
  s.gravity = test::vector("0", "0", "-10");
  s.natural_lengths = {{"line", {{{0, 1}, {1, 0.5}}, true, test::expression("1")}}};
  const Model model = test::model(s, test::chain(1, {0, 0, 0}, {0, 0, -1}));
  Integrator::Options options{0.5, 0.0, {.displacement_tolerance = 1e-13}};
  options.statics = true;
  options.ramp = {0, 1};
  Integrator integrator(model, options, rest_state(model));
  ASSERT_TRUE(integrator.check_mechanism());
  test::settle(integrator, 0.1, 10);
  EXPECT_NEAR(integrator.committed().u[5], -(0.5 * (1 + 20.0 / 100) - 1), 1e-12);
  const Balance b = integrator.balance();
  EXPECT_LT(b.unbalance, 1e-10);
  EXPECT_NEAR(b.reactions[0][2], 20, 1e-9);
  EXPECT_NEAR(b.energy_lost, 0, 0.02 * b.ledger.actuator);
}

TEST(Statics, MechanismIsNamed) {
  Settings s;
  s.trusses = {{"line", {1e-4, 0.0, 1e6, 0, StrainMeasure::green, false}, {}}};
  s.masses = {{"last", 2.0}};
  s.supports = {{"first", {true, true, true}, {}}};
  s.ignored_groups = {"middle"};
  const Model model = test::model(s, test::chain(1, {0, 0, 0}, {1, 0, 0}));
  Integrator::Options options;
  options.statics = true;
  Integrator integrator(model, options, rest_state(model));
  const auto checked = integrator.check_mechanism();
  ASSERT_FALSE(checked);
  EXPECT_EQ(exit_status(checked.error()), 2);
  EXPECT_NE(checked.error().message.find("node 1 at (1, 0, 0) of \"line\", \"last\""), std::string::npos)
      << checked.error().message;
}

TEST(Loads, WithoutAValueFailTheStepWithTheirGroup) {
  Swing swing;
  swing.settings.forces = {{"last", test::vector("sqrt(0.05 - t)", "0", "0")}};
  const Model model = swing.model();
  EXPECT_TRUE(load_faults(model, 0).empty());
  ASSERT_EQ(load_faults(model, 1).size(), 1U);
  Integrator integrator(model, {0.5, 0.0, {}}, rest_state(model));
  integrator.begin_step(0.1, Integrator::Predictor::hold);
  const auto outcome = integrator.iterate_to_tolerance();
  ASSERT_FALSE(outcome);
  EXPECT_EQ(exit_status(outcome.error()), 3);
  EXPECT_NE(outcome.error().message.find("force on group \"last\""), std::string::npos)
      << outcome.error().message;
}

} // namespace
} // namespace drogue::structure
