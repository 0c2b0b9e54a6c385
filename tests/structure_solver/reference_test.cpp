// SPDX-License-Identifier: GPL-3.0-or-later
//
// Against exact solutions: elastic catenary [irvine1981], taut cable under a point load, circular membrane
// under lateral load and follower pressure [fichter1997] in its exact St. Venant-Kirchhoff form, inflated
// sphere.
#include <gtest/gtest.h>

#include "tests/structure_solver/test_structures.hpp"
#include "tests/support/verify.hpp"

namespace drogue::structure {
namespace {

using drogue::test::verify_relative;
using mesh::ElementKind;

/// Elastic catenary, level supports: S = 10, EA = 2e4, W = 10, L0 = 10.25: H = 12.4726810, sag = 0.98963217.
TEST(Cable, ElasticCatenary) {
  const int n = 40;
  Settings s;
  LineSettings cable{"line", {1.0, 10.0 / 10.25, 2e4, 0, StrainMeasure::engineering, true}, 10.25 / n};
  s.cables = {cable};
  s.supports = {{"first", {true, true, true}, {}}, {"last", {true, true, true}, {}}};
  s.ignored_groups = {"middle"};
  s.gravity = test::vector("0", "0", "-1");
  const Model model = test::model(s, test::chain(n, {0, 0, 0}, {10, 0, 0}));
  Integrator integrator(model, {0.0, 1.0, {.displacement_tolerance = 1e-9, .max_iterations = 100}},
                        rest_state(model));
  test::settle(integrator, 0.05, 100);
  test::settle(integrator, 0.5, 200);
  const Balance b = integrator.balance();
  EXPECT_LT(b.unbalance, 1e-6);
  verify_relative("structure/catenary", "horizontal_tension", -b.reactions[0][0], 12.4726810, 1e-3);
  verify_relative("structure/catenary", "sag", -integrator.committed().u[3 * (n / 2) + 2], 0.98963217, 1e-3);
}

/// Taut cable, S = 10, EA = 1e4, initial tension 10, P = 5 in the middle: sag 0.35542136, T = 35.258268.
TEST(Cable, TautCableUnderAPointLoad) {
  const int n = 10;
  const double natural = 10 / (1 + 10 / 1e4) / n;
  Settings s;
  s.cables = {{"line", {1.0, 1e-3, 1e4, 0, StrainMeasure::engineering, true}, natural}};
  s.supports = {{"first", {true, true, true}, {}}, {"last", {true, true, true}, {}}};
  s.forces = {{"middle", test::vector("0", "0", "-5")}};
  const Model model = test::model(s, test::chain(n, {0, 0, 0}, {10, 0, 0}));
  Integrator integrator(model, {0.0, 10.0, {.displacement_tolerance = 1e-10, .max_iterations = 50}},
                        rest_state(model));
  test::settle(integrator, 0.5, 60);
  const State& state = integrator.committed();
  verify_relative("structure/taut_cable", "sag", -state.u[3 * (n / 2) + 2], 0.35542136, 1e-4);
  const auto& batch = std::get<Batch<Line>>(model.batches[0]);
  Line::Positions x;
  for (int a = 0; a < 2; ++a)
    for (int c = 0; c < 3; ++c)
      x(c, a) = model.mesh.points[static_cast<std::size_t>(3 * a + c)] +
                state.u[static_cast<std::size_t>(3 * a + c)];
  verify_relative("structure/taut_cable", "tension", Line::tension(batch.reference[0], batch.material, x),
                  35.258268, 1e-4);
}

/// Unit disk of T3: ring k has 6 k edges around. Groups "cloth" and the points "edge".
mesh::Mesh disk(int rings) {
  mesh::Mesh mesh;
  mesh.points = {0, 0, 0};
  std::vector<std::int32_t> first{0};
  mesh::ElementBlock cloth{"cloth", ElementKind::tri3, {}}, edge{"edge", ElementKind::point1, {}};
  for (int k = 1; k <= rings; ++k) {
    first.push_back(mesh.node_count());
    for (int j = 0; j < 6 * k; ++j) {
      const double angle = 2 * std::numbers::pi * j / (6 * k), r = static_cast<double>(k) / rings;
      if (k == rings) edge.nodes.push_back(mesh.node_count());
      mesh.points.insert(mesh.points.end(), {r * std::cos(angle), r * std::sin(angle), 0});
    }
  }
  for (int k = 1; k <= rings; ++k)
    for (int sector = 0; sector < 6; ++sector)
      for (int j = 0; j < k; ++j) {
        const auto outer = [&](int i) {
          return first[static_cast<std::size_t>(k)] + (sector * k + i) % (6 * k);
        };
        const auto inner = [&](int i) {
          return k == 1 ? 0 : first[static_cast<std::size_t>(k) - 1] + (sector * (k - 1) + i) % (6 * (k - 1));
        };
        cloth.nodes.insert(cloth.nodes.end(), {outer(j), outer(j + 1), inner(j)});
        if (j < k - 1) cloth.nodes.insert(cloth.nodes.end(), {inner(j), outer(j + 1), inner(j + 1)});
      }
  mesh.blocks = {std::move(cloth), std::move(edge)};
  return mesh;
}

/// The square [0, 1]^2 on the unit disk: concentric squares become circles.
Eigen::Vector3d square_to_disk(double s, double t) {
  const double x = 2 * s - 1, y = 2 * t - 1, m = std::max(std::abs(x), std::abs(y)), r = std::hypot(x, y);
  return r > 0 ? Eigen::Vector3d(x * m / r, y * m / r, 0) : Eigen::Vector3d::Zero();
}

struct DiskResult {
  double deflection = 0;
  double centre_stress = 0;
};

/// E = t = a = 1, nu = 0.3.
DiskResult load_disk(mesh::Mesh mesh, std::size_t centre, double q, bool follower) {
  Settings s;
  s.membranes = {{"cloth", {1.0, 1.0, 1.0, 0.3, 0}}};
  s.supports = {{"edge", {true, true, true}, {}}};
  const auto value = std::to_string(q);
  if (follower)
    s.pressures = {{"cloth", test::expression(value)}};
  else
    s.tractions = {{"cloth", test::vector("0", "0", value)}};
  const Model model = test::model(s, std::move(mesh));
  Integrator integrator(
      model, {0.0, 0.3, {.displacement_tolerance = 1e-6, .max_iterations = 50, .load_stiffness = follower}},
      rest_state(model));
  test::settle(integrator, 1.0, 6);
  test::settle(integrator, 10.0, 14);
  EXPECT_LT(integrator.balance().unbalance, 1e-4);

  DiskResult result{integrator.committed().u[3 * centre + 2], 0};
  std::visit(
      [&](const auto& batch) {
        using Kernel = typename std::decay_t<decltype(batch)>::KernelType;
        if constexpr (std::is_same_v<typename Kernel::Material, MembraneMaterial>) {
          double nearest = 1e300;
          for (std::size_t e = 0; e < batch.count(); ++e) {
            typename Kernel::Positions X, x;
            for (int a = 0; a < Kernel::nodes; ++a)
              for (int c = 0; c < 3; ++c) {
                const std::size_t i =
                    3 * static_cast<std::size_t>(batch.element(e)[a]) + static_cast<std::size_t>(c);
                X(c, a) = model.mesh.points[i];
                x(c, a) = X(c, a) + integrator.committed().u[i];
              }
            for (std::size_t p = 0; p < Kernel::points; ++p) {
              const double r = (X * element_rule<Kernel::kind>().points[p].N).norm();
              if (r >= nearest) continue;
              nearest = r;
              const auto stress =
                  Kernel::principal_stress(Kernel::point_state(batch.reference[e], batch.material, x, p));
              result.centre_stress = 0.5 * (stress.largest + stress.smallest);
            }
          }
        }
      },
      model.batches[0]);
  return result;
}

TEST(CircularMembrane, FollowerPressureOnTriangles) {
  const DiskResult r = load_disk(disk(25), 0, 0.01, true); // 1,951 nodes
  verify_relative("structure/circular_membrane_follower_t3", "deflection", r.deflection, 0.141385, 5e-3);
  verify_relative("structure/circular_membrane_follower_t3", "centre_stress", r.centre_stress, 0.020395,
                  5e-3);
}

TEST(CircularMembrane, LateralLoadOnTriangles) {
  const DiskResult r = load_disk(disk(25), 0, 0.01, false);
  verify_relative("structure/circular_membrane_lateral_t3", "deflection", r.deflection, 0.140729, 5e-3);
  verify_relative("structure/circular_membrane_lateral_t3", "centre_stress", r.centre_stress, 0.019641, 5e-3);
}

TEST(CircularMembrane, FollowerPressureOnNineNodeQuadrilaterals) {
  mesh::Mesh mesh = test::sheet(ElementKind::quad9, 12, 12, square_to_disk);
  const std::size_t centre = static_cast<std::size_t>(mesh.node_count()) / 2;
  const DiskResult r = load_disk(std::move(mesh), centre, 0.01, true);
  verify_relative("structure/circular_membrane_follower_q9", "deflection", r.deflection, 0.141385, 5e-3);
  verify_relative("structure/circular_membrane_follower_q9", "centre_stress", r.centre_stress, 0.020395,
                  5e-3);
}

} // namespace
} // namespace drogue::structure
