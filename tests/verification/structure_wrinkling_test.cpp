// SPDX-License-Identifier: GPL-3.0-or-later
//
// Membranes as tension fields: the inflated square airbag [contri1988] and the pretensioned strip in bending
// [stein1961]. Newton must converge in every step that counts: no wrinkle state is ever held.
#include <algorithm>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/structure_solver/test_structures.hpp"
#include "tests/support/verify.hpp"

namespace drogue::structure {
namespace {

using drogue::test::verify;
using drogue::test::verify_relative;
using mesh::ElementKind;

constexpr double tiny = 1e-9;

mesh::ElementBlock points_where(const mesh::Mesh& mesh, const std::string& group,
                                const std::function<bool(const double*)>& where) {
  mesh::ElementBlock block{group, ElementKind::point1, {}};
  for (std::int32_t i = 0; i < mesh.node_count(); ++i)
    if (where(&mesh.points[3 * static_cast<std::size_t>(i)])) block.nodes.push_back(i);
  return block;
}

/// Calls use(reference position, stress and state) at every quadrature point of the membranes.
template <class Use>
void at_points(const Model& model, std::span<const double> u, const Use& use) {
  for (const AnyBatch& any : model.batches)
    std::visit(
        [&](const auto& batch) {
          using Kernel = typename std::decay_t<decltype(batch)>::KernelType;
          if constexpr (std::is_same_v<typename Kernel::Material, MembraneMaterial>)
            for (std::size_t e = 0; e < batch.count(); ++e) {
              typename Kernel::Positions X, x;
              for (int a = 0; a < Kernel::nodes; ++a)
                for (int c = 0; c < 3; ++c) {
                  const std::size_t i =
                      3 * static_cast<std::size_t>(batch.element(e)[a]) + static_cast<std::size_t>(c);
                  X(c, a) = model.mesh.points[i];
                  x(c, a) = X(c, a) + u[i];
                }
              const auto& rule = element_rule<Kernel::kind>();
              for (std::size_t q = 0; q < Kernel::points; ++q)
                use(Eigen::Vector3d(X * rule.points[q].N),
                    Kernel::point_state(batch.reference[e], batch.material, x, q));
            }
        },
        any);
}

/// Damped dynamics with growing steps to a force unbalance of 1e-4; every step is one that Newton converged.
void find_equilibrium(Integrator& integrator, double first_step) {
  double dt = first_step;
  for (int attempt = 0; attempt < 200; ++attempt) {
    integrator.begin_step(dt, Integrator::Predictor::hold);
    const auto outcome = integrator.iterate_to_tolerance();
    if (!outcome || !outcome->converged) {
      integrator.rollback();
      dt *= 0.5;
      continue;
    }
    integrator.commit();
    if (integrator.balance().unbalance < 1e-4) return;
    if (outcome->iterations < 10) dt *= 1.5;
    if (outcome->iterations > 16) dt *= 0.7;
  }
  ADD_FAILURE() << "no equilibrium: unbalance " << integrator.balance().unbalance;
}

/// Two square sheets joined along their edges, diagonal 1.2 m, under 5 kPa; a quarter of the upper one.
namespace airbag {

constexpr double half_edge = 0.6 / std::numbers::sqrt2;

/// Turns the diagonals of test::sheet, which run from the centre to the corner, across.
void turn_diagonals(std::vector<std::int32_t>& nodes) {
  for (std::size_t t = 0; t < nodes.size(); t += 6) {
    const std::int32_t a = nodes[t], b = nodes[t + 1], c = nodes[t + 2], d = nodes[t + 5];
    const std::int32_t turned[] = {a, b, d, b, c, d};
    std::copy(turned, turned + 6, &nodes[t]);
  }
}

/// n x n Q9, or 2n x 2n pairs of T3.
Model model(ElementKind kind, int n) {
  mesh::Mesh mesh = test::sheet(
      kind, n, n, [](double s, double t) { return Eigen::Vector3d(half_edge * s, half_edge * t, 0); });
  if (kind == ElementKind::tri3) turn_diagonals(mesh.blocks[0].nodes);
  mesh.blocks.push_back(points_where(mesh, "x0", [](const double* X) { return X[0] < tiny; }));
  mesh.blocks.push_back(points_where(mesh, "y0", [](const double* X) { return X[1] < tiny; }));
  mesh.blocks.push_back(
      points_where(mesh, "seam", [](const double* X) { return std::max(X[0], X[1]) > half_edge - tiny; }));
  Settings s;
  s.membranes = {{"cloth",
                  {.thickness = 6e-4,
                   .density = 1e6, // of damped dynamics; the equilibrium does not know it
                   .youngs_modulus = 588e6,
                   .poisson_ratio = 0.4,
                   .wrinkling = Wrinkling::tension_field}}};
  s.supports = {
      {"x0", {true, false, false}, {}}, {"y0", {false, true, false}, {}}, {"seam", {false, false, true}, {}}};
  s.pressures = {{"cloth", test::expression("5000")}};
  s.ignored_groups = {"edge"};
  return test::model(s, std::move(mesh));
}

struct Shape {
  double w_M = 0;     ///< rise of the centre [m]
  double u_B = 0;     ///< inward displacement of the middle of an edge [m]
  double sigma_1 = 0; ///< largest principal stress at the point next to the centre [Pa]
  double sigma_2 = 0; ///< smallest principal stress anywhere [Pa]
};

Shape inflate(ElementKind kind, int n) {
  const Model model = airbag::model(kind, n);
  Integrator integrator(
      model, {0.0, 5.0, {.displacement_tolerance = 1e-7, .residual_tolerance = 1e-12, .max_iterations = 25}},
      rest_state(model));
  find_equilibrium(integrator, 0.01);
  const std::vector<double>& u = integrator.committed().u;
  Shape shape{u[2], -u[3 * static_cast<std::size_t>(2 * n)], 0, 0};
  double nearest = 1;
  at_points(model, u, [&](const Eigen::Vector3d& X, const auto& at) {
    const auto p = Membrane<ElementKind::tri3>::principal_stress({at.strain, at.stress, at.wrinkle_state});
    shape.sigma_2 = std::min(shape.sigma_2, p.smallest);
    if (X.norm() >= nearest) return;
    nearest = X.norm();
    shape.sigma_1 = p.largest;
  });
  return shape;
}

} // namespace airbag

// References: computations with other wrinkling models on 8 x 8 and 10 x 10 elements, w_M = 0.2050 to 0.2167
// m, most of them 0.2166; u_B = 0.1227 m, sigma_1 = 3.8 MPa.
constexpr double w_M = 0.2166, u_B = 0.1227, sigma_1 = 3.8e6;

TEST(Airbag, Triangles) {
  const airbag::Shape coarse = airbag::inflate(ElementKind::tri3, 4),
                      fine = airbag::inflate(ElementKind::tri3, 8);
  verify_relative("structure/airbag_t3_16x16", "w_M", fine.w_M, w_M, 0.01);
  verify_relative("structure/airbag_t3_16x16", "u_B", fine.u_B, u_B, 0.03);
  verify_relative("structure/airbag_t3_16x16", "sigma_1", fine.sigma_1, sigma_1, 0.03);
  verify("structure/airbag_t3_16x16", "compression", fine.sigma_2 / sigma_1, 0, 1e-12);
  verify_relative("structure/airbag_t3_8x8", "w_M", coarse.w_M, w_M, 0.02);
  verify_relative("structure/airbag_t3_8x8", "u_B", coarse.u_B, u_B, 0.05);
  verify_relative("structure/airbag_t3_8x8", "sigma_1", coarse.sigma_1, sigma_1, 0.03);
}

/// The stress at the point of integration next to the centre is left out: it converges from 18 % above.
TEST(Airbag, NineNodeQuadrilaterals) {
  const airbag::Shape coarse = airbag::inflate(ElementKind::quad9, 4),
                      fine = airbag::inflate(ElementKind::quad9, 8);
  verify_relative("structure/airbag_q9_8x8", "w_M", fine.w_M, w_M, 0.01);
  verify_relative("structure/airbag_q9_8x8", "u_B", fine.u_B, u_B, 0.03);
  verify("structure/airbag_q9_8x8", "compression", fine.sigma_2 / sigma_1, 0, 1e-12);
  verify_relative("structure/airbag_q9_4x4", "w_M", coarse.w_M, w_M, 0.01);
  verify_relative("structure/airbag_q9_4x4", "u_B", coarse.u_B, u_B, 0.03);
  EXPECT_LT(std::abs(fine.sigma_1 / sigma_1 - 1), 0.5 * std::abs(coarse.sigma_1 / sigma_1 - 1));
}

/// Strip of length 1 and height 1 under the tension sigma_0 in both directions, bent by turning its end.
namespace strip {

constexpr double E = 1, sigma_0 = 1e-6, height = 1, length = 1;

/// Normal traction sigma_0 on y = 0 and y = height, as consistent nodal forces: nodes of equal force form a
/// group.
void pull_across(Settings& s, mesh::Mesh& mesh, ElementKind kind, int m) {
  for (const double y : {0.0, height}) {
    std::map<double, mesh::ElementBlock> by_force;
    for (std::int32_t i = 0; i < mesh.node_count(); ++i) {
      const double* X = &mesh.points[3 * static_cast<std::size_t>(i)];
      if (std::abs(X[1] - y) > tiny) continue;
      const long column = std::lround(X[0] / length * 2 * m);
      const bool end = column == 0 || column == 2 * m, middle = column % 2 == 1;
      const double share = kind == ElementKind::tri3 ? (end ? 0.25 : 0.5)
                           : middle                  ? 4. / 6
                           : end                     ? 1. / 6
                                                     : 2. / 6;
      by_force[share * sigma_0 * length / m].nodes.push_back(i);
    }
    for (auto& [force, block] : by_force) {
      block.group = "pull" + std::to_string(mesh.blocks.size());
      block.kind = ElementKind::point1;
      s.forces.push_back(
          {block.group, test::vector("0", fmt::format("{:.17g}", y > 0 ? force : -force), "0")});
      mesh.blocks.push_back(std::move(block));
    }
  }
}

/// m x n Q9, or 2m x 2n pairs of T3; the end x = length moves by u_x = length (strain + curvature y).
Model model(ElementKind kind, int m, int n, double strain, double curvature) {
  mesh::Mesh mesh =
      test::sheet(kind, m, n, [](double s, double t) { return Eigen::Vector3d(length * s, height * t, 0); });
  Settings s;
  mesh.blocks.push_back(points_where(mesh, "middle", [](const double* X) { return X[0] < tiny; }));
  mesh.blocks.push_back(points_where(mesh, "end", [](const double* X) { return X[0] > length - tiny; }));
  mesh.blocks.push_back(
      points_where(mesh, "corner", [](const double* X) { return X[0] < tiny && X[1] > height - tiny; }));
  pull_across(s, mesh, kind, m);
  s.membranes = {{"cloth",
                  {.thickness = 1,
                   .density = 1e-12,
                   .youngs_modulus = E,
                   .poisson_ratio = 0.3,
                   .wrinkling = Wrinkling::tension_field}}};
  s.supports = {
      {"cloth", {false, false, true}, {}},
      {"middle", {true, false, false}, {}},
      {"corner", {false, true, false}, {}},
      {"end",
       {true, false, false},
       test::vector(fmt::format("{:.17g} + {:.17g} * y", length * strain, length * curvature), "0", "0")}};
  s.ignored_groups = {"edge"};
  return test::model(s, std::move(mesh));
}

struct Bending {
  double k = 0;      ///< E t h^2 curvature / (2 P)
  double moment = 0; ///< 2 M / (P h)
  double band = 0;   ///< b / h, from the line through the stresses of the taut part
};

Bending bend(ElementKind kind, int m, int n, double k) {
  // The curvature of k, and the strain that gives about the axial force sigma_0 h; the force itself is
  // measured.
  const double curvature = 2 * k * sigma_0 / (E * height), band = k > 1 ? height * (1 - 1 / std::sqrt(k)) : 0;
  const double strain =
      (k > 1 ? -curvature * band : sigma_0 / E - curvature * height / 2) - 0.3 * sigma_0 / E;
  const Model model = strip::model(kind, m, n, strain, curvature);
  Integrator integrator(
      model, {0.0, 0.0, {.displacement_tolerance = 1e-14, .residual_tolerance = 1e-11, .max_iterations = 40}},
      rest_state(model));
  test::settle(integrator, 1, 2); // almost without mass: Newton from the flat strip in one step
  EXPECT_LT(integrator.balance().unbalance, 1e-6);

  const std::vector<double>& u = integrator.committed().u;
  std::vector<double> force(u.size());
  Assembler(model).assemble({.displacement = u, .load_displacement = u, .loads = *evaluate_loads(model, 0)},
                            force);
  double P = 0, M = 0;
  for (const std::int32_t node : model.mesh.nodes_of("end")) {
    const std::size_t i = 3 * static_cast<std::size_t>(node);
    P += force[i];
    M += force[i] * (model.mesh.points[i + 1] - height / 2);
  }
  // S_xx = trace - sigma_0 where taut: the line a + c y through it vanishes at b.
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  at_points(model, u, [&](const Eigen::Vector3d& X, const auto& at) {
    if (at.wrinkle_state != WrinkleState::taut) return;
    const Eigen::Vector2d line(1, X(1));
    normal += line * line.transpose();
    right += line * (at.stress(0) + at.stress(1) - sigma_0);
  });
  const Eigen::Vector2d line = normal.inverse() * right;
  return {E * height * height * curvature / (2 * P), 2 * M / (P * height), -line(0) / line(1) / height};
}

} // namespace strip

/// [stein1961]: 2 M / (P h) = 1 - 2/3 k^(-1/2) and b / h = 1 - k^(-1/2) for k > 1, k / 3 and 0 below.
double moment_of(double k) {
  return k > 1 ? 1 - 2 / (3 * std::sqrt(k)) : k / 3;
}
double band_of(double k) {
  return 1 - 1 / std::sqrt(k);
}

void check_bending(const std::string& name, ElementKind kind, int m, int n) {
  for (const double k : {1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0}) {
    const strip::Bending bending = strip::bend(kind, m, n, k);
    EXPECT_NEAR(bending.k, k, 0.01 * k);
    verify_relative(name, fmt::format("moment_at_k_{}", k), bending.moment, moment_of(bending.k), 0.01);
    verify_relative(name, fmt::format("band_at_k_{}", k), bending.band, band_of(bending.k), 0.01);
  }
}

TEST(Strip, BendingOfTriangles) {
  check_bending("structure/stein_hedgepeth_t3", ElementKind::tri3, 16, 16);
  const auto error = [](int n) {
    const strip::Bending bending = strip::bend(ElementKind::tri3, n, n, 4);
    return std::abs(bending.moment - moment_of(bending.k));
  };
  verify("structure/stein_hedgepeth_t3", "moment_order", std::log2(error(8) / error(16)), 2, 0.2);
}

TEST(Strip, BendingOfNineNodeQuadrilaterals) {
  check_bending("structure/stein_hedgepeth_q9", ElementKind::quad9, 2, 16);
  const strip::Bending taut = strip::bend(ElementKind::quad9, 2, 8, 0.5); // no wrinkles yet
  verify_relative("structure/stein_hedgepeth_q9", "moment_at_k_0.5", taut.moment, moment_of(0.5), 1e-3);
}

} // namespace
} // namespace drogue::structure
