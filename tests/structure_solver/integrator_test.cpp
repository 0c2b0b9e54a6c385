// SPDX-License-Identifier: GPL-3.0-or-later
//
// The whole residual: tangent with inertia and load stiffness, patch test, momentum, time integration,
// repeatability.
#include <gtest/gtest.h>

#include "tests/structure_solver/test_structures.hpp"

namespace drogue::structure {
namespace {

using mesh::ElementKind;
using test::Numbers;

Eigen::Vector3d distorted(double s, double t) {
  return {s + 0.08 * std::sin(3 * s + 2 * t), t + 0.06 * std::cos(4 * s - t), 0};
}

Settings cloth_settings() {
  Settings s;
  s.membranes = {{"cloth", {0.01, 6.0, 2e5, 0.3, 0}}};
  s.ignored_groups = {"edge"};
  return s;
}

/// A sheet of either kind with cables along one edge, under every kind of load.
Model loaded_model(ElementKind kind) {
  mesh::Mesh mesh = test::sheet(kind, 2, 2, distorted);
  mesh.blocks.push_back({"hem", ElementKind::line2, {0, 1, 1, 2, 2, 3, 3, 4}});
  mesh.blocks.push_back({"corner", ElementKind::point1, {24}});
  Settings s = cloth_settings();
  s.membranes[0].material.prestress = 100;
  s.cables = {{"hem", {1e-3, 6.0, 4e6, 50.0, StrainMeasure::green, true}, {}}};
  s.masses = {{"corner", 0.5}};
  s.supports = {{"corner", {true, false, true}, test::vector("0.01*t", "0", "0.02*t")}};
  s.pressures = {{"cloth", test::expression("20 + 5*x - 3*y + t")}};
  s.tractions = {{"cloth", test::vector("1", "2*x", "3*t")}};
  s.gravity = test::vector("0", "0", "-9.81");
  s.point_drag = {{"corner", 0.4, test::vector("1 + 0.3*x", "y*z", "t - 2"), false}};
  s.line_drag = {{"hem", 3.0, test::vector("2*y", "x + z", "3"), false},
                 {"hem", 4.0, test::vector("1", "y*y", "2"), true}};
  s.natural_lengths = {{"hem", {{{0, 1}, {0.1, 0.9}}, true, test::expression("1 + 0.1*t")}}};
  return test::model(s, std::move(mesh));
}

void check_whole_tangent(ElementKind kind, GeneralisedAlpha scheme) {
  const Model model = loaded_model(kind);
  State state = rest_state(model);
  Numbers numbers;
  for (std::size_t i = 0; i < state.u.size(); ++i) {
    state.u[i] = 0.02 * numbers();
    state.v[i] = numbers();
    state.a[i] = 10 * numbers();
  }
  Integrator::Options options{scheme, 3.0, {.load_stiffness = true}};
  options.stiffness_damping = 0.01;
  Integrator integrator(model, options, state);
  integrator.begin_step(0.05, Integrator::Predictor::extrapolate);

  const std::size_t n = model.equation_count();
  std::vector<double> u = integrator.trial().u, direction(n), r(n), plus(n), minus(n);
  std::vector<std::int32_t> nodes(model.node_count());
  for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] = static_cast<std::int32_t>(i);
  for (std::size_t i = 0; i < n; ++i) {
    u[i] += 0.02 * numbers();
    direction[i] = model.held[i] ? 0 : numbers();
  }
  integrator.set_displacement(nodes, u);
  integrator.residual(r, true);
  const Eigen::VectorXd exact =
      integrator.tangent() * Eigen::Map<const Eigen::VectorXd>(direction.data(), static_cast<int>(n));
  const double h = 1e-6;
  const auto residual_at = [&](double step, std::vector<double>& out) {
    std::vector<double> moved = u;
    for (std::size_t i = 0; i < n; ++i) moved[i] += step * direction[i];
    integrator.set_displacement(nodes, moved);
    integrator.residual(out, false);
  };
  residual_at(h, plus);
  residual_at(-h, minus);
  double error = 0;
  for (std::size_t i = 0; i < n; ++i)
    error = std::max(error, std::abs((plus[i] - minus[i]) / (2 * h) - exact(static_cast<int>(i))));
  EXPECT_LT(error, 2e-8 * exact.cwiseAbs().maxCoeff());
}

TEST(Integrator, TangentOfTheWholeResidual) {
  check_whole_tangent(ElementKind::tri3, 0.6);
  check_whole_tangent(ElementKind::quad9, 0.6);
  check_whole_tangent(ElementKind::tri3, GeneralisedAlpha::hht(-0.2));
  check_whole_tangent(ElementKind::tri3, GeneralisedAlpha::newmark(0.3, 0.6));
}

/// Residual, tangent and energy have the same bits whatever the number of threads.
void check_threads(ElementKind kind) {
  const Model model = loaded_model(kind);
  const LoadValues loads = *evaluate_loads(model, 0.3);
  std::vector<double> u(model.equation_count()), reference(u.size()), r(u.size());
  Numbers numbers;
  for (double& value : u) value = 0.02 * numbers();
  const Assembler::Request request{.displacement = u,
                                   .load_displacement = u,
                                   .loads = loads,
                                   .tangent = true,
                                   .tangent_scale = 0.7,
                                   .load_scale = 0.7,
                                   .load_stiffness = true};
  Assembler alone(model, 1);
  const double energy = alone.assemble(request, reference);
  EXPECT_GT(energy, 0);
  EXPECT_GT(alone.tangent().norm(), 0);
  for (const int threads : {2, 3, 7}) {
    Assembler several(model, threads);
    for (int again = 0; again < 3; ++again) {
      EXPECT_EQ(several.assemble(request, r), energy);
      EXPECT_EQ(r, reference);
      EXPECT_TRUE(std::equal(several.tangent().valuePtr(),
                             several.tangent().valuePtr() + several.tangent().nonZeros(),
                             alone.tangent().valuePtr()));
    }
  }
}

TEST(Assembler, ThreadsDoNotChangeABit) {
  check_threads(ElementKind::tri3);
  check_threads(ElementKind::quad9);
}

/// Affine in-plane stretch of a distorted patch, prescribed on its edge: the inner nodes follow it, the
/// stress is the constant one of St. Venant-Kirchhoff.
void check_patch(ElementKind kind) {
  Settings s = cloth_settings();
  s.ignored_groups.clear();
  s.supports = {{"edge", {true, true, true}, test::vector("0.05*x + 0.02*y", "-0.01*x + 0.03*y", "0")}};
  s.membranes[0].material.prestress = 10;
  const Model model = test::model(s, test::sheet(kind, 2, 2, distorted));
  Integrator integrator(model, {0.0, 50.0, {.displacement_tolerance = 1e-13, .residual_tolerance = 1e-14}},
                        rest_state(model));
  test::settle(integrator, 1.0, 40);

  const State& state = integrator.committed();
  for (std::size_t i = 0; i < model.node_count(); ++i) {
    const double x = model.mesh.points[3 * i], y = model.mesh.points[3 * i + 1];
    EXPECT_NEAR(state.u[3 * i], 0.05 * x + 0.02 * y, 1e-11);
    EXPECT_NEAR(state.u[3 * i + 1], -0.01 * x + 0.03 * y, 1e-11);
  }
  Eigen::Matrix2d F;
  F << 1.05, 0.02, -0.01, 1.03;
  const Eigen::Matrix2d E = 0.5 * (F.transpose() * F - Eigen::Matrix2d::Identity());
  const Eigen::Matrix2d S = 2e5 / (1 - 0.09) * (0.7 * E + 0.3 * E.trace() * Eigen::Matrix2d::Identity()) +
                            10 * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d exact = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(S).eigenvalues();
  std::visit(
      [&](const auto& batch) {
        using Kernel = typename std::decay_t<decltype(batch)>::KernelType;
        if constexpr (std::is_same_v<typename Kernel::Material, MembraneMaterial>)
          for (std::size_t e = 0; e < batch.count(); ++e) {
            typename Kernel::Positions x;
            for (int a = 0; a < Kernel::nodes; ++a)
              for (int c = 0; c < 3; ++c) {
                const std::size_t i =
                    3 * static_cast<std::size_t>(batch.element(e)[a]) + static_cast<std::size_t>(c);
                x(c, a) = model.mesh.points[i] + state.u[i];
              }
            for (std::size_t q = 0; q < Kernel::points; ++q) {
              const auto p =
                  Kernel::principal_stress(Kernel::point_state(batch.reference[e], batch.material, x, q));
              EXPECT_NEAR(p.largest, exact(1), 1e-7 * exact(1));
              EXPECT_NEAR(p.smallest, exact(0), 1e-7 * exact(1));
            }
          }
      },
      model.batches[0]);
}

TEST(Membrane, PatchTestWithTriangles) {
  check_patch(ElementKind::tri3);
}
TEST(Membrane, PatchTestWithNineNodeQuadrilaterals) {
  check_patch(ElementKind::quad9);
}

TEST(Integrator, FreeFallKeepsMomentum) {
  Settings s = cloth_settings();
  s.gravity = test::vector("0", "1.5", "-9.81");
  const Model model = test::model(s, test::sheet(ElementKind::quad9, 2, 2, distorted));
  State start = rest_state(model);
  Numbers numbers;
  for (double& v : start.v) v = 0.3 * numbers();
  double mass = 0;
  Eigen::Vector3d p0 = Eigen::Vector3d::Zero();
  const auto momentum = [&](const State& state) {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < model.node_count(); ++i)
      p += model.mass[i] * Eigen::Vector3d(&state.v[3 * i]);
    return p;
  };
  for (const double m : model.mass) mass += m;
  Integrator integrator(model, {0.8, 0.0, {.displacement_tolerance = 1e-13}}, std::move(start));
  integrator.balance_start();
  p0 = momentum(integrator.committed());
  test::settle(integrator, 1e-3, 50);
  const Eigen::Vector3d gained = momentum(integrator.committed()) - p0;
  EXPECT_NEAR(gained(0), 0, 1e-11 * mass);
  EXPECT_NEAR(gained(1), mass * 1.5 * 0.05, 1e-11 * mass);
  EXPECT_NEAR(gained(2), -mass * 9.81 * 0.05, 1e-11 * mass);
}

/// Mass on a truss, oscillating along it: period 2 pi sqrt(m L / EA) in the limit of small amplitude.
double period_error(double dt) {
  mesh::Mesh mesh = test::chain(1, {0, 0, 0}, {1, 0, 0});
  Settings s;
  s.trusses = {{"line", {1.0, 0.0, 4.0, 0, StrainMeasure::engineering, false}, {}}};
  s.masses = {{"last", 1.0}};
  s.supports = {{"first", {true, true, true}, {}}};
  s.ignored_groups = {"middle"};
  const Model model = test::model(s, std::move(mesh));
  State start = rest_state(model);
  start.u[3] = 1e-3;
  Integrator integrator(model, {0.8, 0.0, {.displacement_tolerance = 1e-12}}, std::move(start));
  integrator.balance_start();
  const int steps = static_cast<int>(std::lround(2.0 / dt));
  for (int k = 0; k < steps; ++k) {
    integrator.begin_step(dt, Integrator::Predictor::extrapolate);
    EXPECT_TRUE(integrator.iterate_to_tolerance());
    integrator.commit();
  }
  return std::abs(integrator.committed().u[3] - 1e-3 * std::cos(2 * 2.0)) / 1e-3;
}

TEST(Integrator, SecondOrderInTime) {
  const double coarse = period_error(0.04), fine = period_error(0.02), finest = period_error(0.01);
  EXPECT_GT(std::log2(coarse / fine), 1.9);
  EXPECT_LT(std::log2(coarse / fine), 2.1);
  EXPECT_GT(std::log2(fine / finest), 1.9);
  EXPECT_LT(finest, 2e-4); // (omega dt)^2 omega t / 12 times a factor near one
}

TEST(Integrator, SameStepGivesTheSameBitsAndRollbackRestores) {
  const Model model = loaded_model(ElementKind::quad9);
  Integrator integrator(model, {0.5, 0.0, {}}, rest_state(model));
  test::settle(integrator, 0.01, 2);
  const State before = integrator.committed();
  std::vector<double> force(model.equation_count());
  Numbers numbers;
  for (double& f : force) f = 0.1 * numbers();
  const auto step = [&] {
    integrator.begin_step(0.01, Integrator::Predictor::extrapolate);
    integrator.set_interface_force(force);
    EXPECT_TRUE(integrator.iterate(2));
    return integrator.trial();
  };
  const State first = step();
  integrator.rollback();
  EXPECT_EQ(integrator.trial().u, before.u);
  EXPECT_EQ(integrator.trial().a, before.a);
  integrator.begin_step(0.003, Integrator::Predictor::hold); // another attempt in between leaves no trace
  EXPECT_TRUE(integrator.iterate_to_tolerance());
  integrator.rollback();
  const State second = step();
  EXPECT_EQ(first.u, second.u);
  EXPECT_EQ(first.v, second.v);
  EXPECT_EQ(first.a, second.a);
}

TEST(Integrator, WeighsTheFluidForceWithAlphaF) {
  // One free mass: a_m = f_m / m gives the acceleration in closed form.
  mesh::Mesh mesh;
  mesh.points = {0, 0, 0};
  mesh.blocks = {{"ball", ElementKind::point1, {0}}};
  Settings s;
  s.masses = {{"ball", 2.0}};
  const Model model = test::model(s, std::move(mesh));
  Integrator integrator(model, {0.5, 0.0, {}}, rest_state(model));
  const auto alpha = GeneralisedAlpha::from_rho(0.5);
  double a = 0, f_n = 0;
  for (int k = 1; k <= 3; ++k) {
    const double f = k * 4.0;
    integrator.begin_step(0.1, Integrator::Predictor::hold);
    integrator.set_interface_force(std::vector<double>{f, 0, 0});
    ASSERT_TRUE(integrator.iterate_to_tolerance());
    integrator.commit();
    const double f_m = k == 1 ? f : (1 - alpha.alpha_f) * f + alpha.alpha_f * f_n;
    a = (f_m / 2.0 - alpha.alpha_m * a) / (1 - alpha.alpha_m);
    f_n = f;
    EXPECT_NEAR(integrator.committed().a[0], a, 1e-11);
  }
}

TEST(Integrator, ReactionsCarryTheWeight) {
  Settings s;
  s.trusses = {{"line", {1e-3, 100.0, 1e6, 0, StrainMeasure::green, false}, {}}};
  s.supports = {{"first", {true, true, true}, {}}};
  s.ignored_groups = {"last", "middle"};
  s.gravity = test::vector("0", "0", "-10");
  const Model model = test::model(s, test::chain(4, {0, 0, 0}, {0, 0, -2}));
  Integrator integrator(model, {0.0, 20.0, {.displacement_tolerance = 1e-12}}, rest_state(model));
  test::settle(integrator, 0.5, 30);
  const Balance b = integrator.balance();
  ASSERT_EQ(b.reactions.size(), 1U);
  EXPECT_NEAR(b.reactions[0][2], 1e-3 * 100 * 2 * 10, 1e-6);
  EXPECT_LT(b.unbalance, 1e-6);
}

} // namespace
} // namespace drogue::structure
