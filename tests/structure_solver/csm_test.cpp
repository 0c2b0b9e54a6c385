// SPDX-License-Identifier: GPL-3.0-or-later
//
// The structural benchmarks of [turek2006]: an elastic flag behind a rigid cylinder under its own weight,
// plane strain. Displacement of the middle A of its free end; references: FeatFlow's finest meshes, in mm and
// Hz.
#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/structure_solver/test_structures.hpp"
#include "tests/support/verify.hpp"

namespace drogue::structure {
namespace {

using drogue::test::verify_relative;
using mesh::ElementKind;

/// The flag of n x m patches of 3 x 3 nodes. Its left end lies on the cylinder around (0.2, 0.2).
struct Flag {
  Model model;
  std::size_t tip = 0; ///< node A at (0.6, 0.2)
};

Flag flag(ElementKind kind, int n, int m, double youngs_modulus, const std::string& gravity) {
  mesh::Mesh mesh = test::sheet(kind, n, m, [](double s, double t) {
    const double y = 0.02 * (t - 0.5), left = 0.2 + std::sqrt(0.05 * 0.05 - y * y);
    return Eigen::Vector3d(left + s * (0.6 - left), 0.2 + y, 0);
  });
  mesh::ElementBlock root{"root", ElementKind::point1, {}};
  for (int j = 0; j <= 2 * m; ++j) root.nodes.push_back(j * (2 * n + 1));
  mesh.blocks.push_back(std::move(root));
  Settings s;
  s.plane = true;
  s.solids = {{"cloth", {1000, youngs_modulus, 0.4}}};
  s.supports = {{"root", {true, true, true}, {}}};
  s.gravity = test::vector("0", gravity, "0");
  return {test::model(s, std::move(mesh)), static_cast<std::size_t>(m * (2 * n + 1) + 2 * n)};
}

std::string lower(ElementKind kind) {
  return kind == ElementKind::quad9 ? "q9" : "t6";
}

Eigen::Vector2d at_rest(ElementKind kind, int n, int m, double youngs_modulus) {
  const Flag f = flag(kind, n, m, youngs_modulus, "-0.2*min(t, 10)");
  Integrator integrator(f.model, {0.0, 20.0, {.displacement_tolerance = 1e-8, .max_iterations = 30}},
                        rest_state(f.model));
  test::settle(integrator, 1.0, 10);
  test::settle(integrator, 10.0, 4);
  EXPECT_LT(integrator.balance().unbalance, 1e-4);
  const auto& u = integrator.committed().u;
  return {1e3 * u[3 * f.tip], 1e3 * u[3 * f.tip + 1]};
}

/// CSM1: E = 1.4e6; CSM2: E = 5.6e6.
void check_static(const std::string& name, double youngs_modulus, double u_x, double u_y) {
  for (const ElementKind kind : {ElementKind::quad9, ElementKind::tri6}) {
    const std::string id = "structure/" + name + "_" + lower(kind);
    const Eigen::Vector2d coarse = at_rest(kind, 18, 1, youngs_modulus),
                          middle = at_rest(kind, 36, 2, youngs_modulus),
                          fine = at_rest(kind, 72, 4, youngs_modulus);
    // The coarse mesh, one element or pair across, shows the trend.
    const double coarse_tolerance = kind == ElementKind::quad9 ? 0.025 : 0.06;
    verify_relative(id, "u_x_18x1", coarse(0), u_x, coarse_tolerance);
    verify_relative(id, "u_y_18x1", coarse(1), u_y, coarse_tolerance);
    verify_relative(id, "u_x_36x2", middle(0), u_x, 0.015);
    verify_relative(id, "u_y_36x2", middle(1), u_y, 0.015);
    verify_relative(id, "u_x_72x4", fine(0), u_x, 0.005);
    verify_relative(id, "u_y_72x4", fine(1), u_y, 0.005);
    EXPECT_LT((fine - middle).norm(), 0.5 * (middle - coarse).norm());
  }
}

TEST(Csm, One) {
  check_static("csm1", 1.4e6, -7.187, -66.102);
}

TEST(Csm, Two) {
  check_static("csm2", 5.6e6, -0.46901, -16.974);
}

/// An extremum of a sampled curve, by a parabola through its neighbours.
struct Extremum {
  double time = 0, value = 0;
};
std::vector<Extremum> minima(const std::vector<double>& samples, double dt) {
  std::vector<Extremum> found;
  for (std::size_t k = 1; k + 1 < samples.size(); ++k) {
    const double a = samples[k - 1], b = samples[k], c = samples[k + 1];
    if (!(b < a && b <= c)) continue;
    const double shift = 0.5 * (a - c) / (a - 2 * b + c);
    found.push_back({dt * (static_cast<double>(k) + shift), b - 0.25 * (a - c) * shift});
  }
  return found;
}

/// CSM3: CSM1 let go at rest, undamped. Mean, amplitude and frequency of the last period.
void check_swing(ElementKind kind, double dt, double duration) {
  const Flag f = flag(kind, 36, 2, 1.4e6, "-2");
  Integrator integrator(f.model, {0.95, 0.0, {.displacement_tolerance = 1e-9, .max_iterations = 30}},
                        rest_state(f.model));
  integrator.balance_start();
  std::vector<double> x, y;
  while (integrator.committed().time < duration) {
    x.push_back(1e3 * integrator.committed().u[3 * f.tip]);
    y.push_back(1e3 * integrator.committed().u[3 * f.tip + 1]);
    integrator.begin_step(dt, Integrator::Predictor::extrapolate);
    const auto outcome = integrator.iterate_to_tolerance();
    ASSERT_TRUE(outcome && outcome->converged);
    integrator.commit();
  }
  const auto lowest = minima(y, dt);
  ASSERT_GE(lowest.size(), 2U);
  const double start = lowest[lowest.size() - 2].time, end = lowest.back().time;
  const auto last_period = [&](const std::vector<double>& u) {
    const auto first = u.begin() + static_cast<std::ptrdiff_t>(start / dt),
               last = u.begin() + static_cast<std::ptrdiff_t>(end / dt) + 2;
    const auto [low, high] = std::minmax_element(first, last);
    return std::pair(0.5 * (*high + *low), 0.5 * (*high - *low));
  };
  const std::string id = "structure/csm3_" + lower(kind);
  verify_relative(id, "u_x_mean", last_period(x).first, -14.305, 0.015);
  verify_relative(id, "u_x_amplitude", last_period(x).second, 14.305, 0.015);
  verify_relative(id, "u_y_mean", last_period(y).first, -63.607, 0.015);
  verify_relative(id, "u_y_amplitude", last_period(y).second, 65.160, 0.015);
  verify_relative(id, "frequency", 1 / (end - start), 1.0995, 0.015);
}

TEST(Csm, Three) {
  check_swing(ElementKind::quad9, 0.01, 3.0);
  check_swing(ElementKind::tri6, 0.01, 3.0);
}

} // namespace
} // namespace drogue::structure
