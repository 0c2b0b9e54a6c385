// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/pseudo_solid.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "mesh_mover/quality.hpp"

namespace drogue::mesh_mover {
namespace {

const std::vector<double> corner = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
const std::vector<double> skewed = {0.1, 0, 0.2, 1.3, 0.1, 0, 0.2, 0.9, 0.1, -0.1, 0.3, 1.4};
const std::vector<std::int32_t> nodes = {0, 1, 2, 3};

TEST(PseudoSolid, GeometryOfTheUnitCorner) {
  const auto element = simplex_geometry<3>(corner, nodes);
  EXPECT_DOUBLE_EQ(element.jacobian, 1);
  Eigen::Matrix<double, 3, 4> expected;
  expected << -1, 1, 0, 0, -1, 0, 1, 0, -1, 0, 0, 1;
  EXPECT_TRUE(element.gradients.isApprox(expected));
  const auto triangle = simplex_geometry<2>(corner, nodes);
  EXPECT_DOUBLE_EQ(triangle.jacobian, 1);
  EXPECT_TRUE(triangle.gradients.isApprox(expected.topLeftCorner(2, 3)));
}

template <int D>
void expect_symmetric_blocks_without_rigid_motions() {
  using Vector = Eigen::Matrix<double, D, 1>;
  using Block = Eigen::Matrix<double, D, D>;
  const PseudoSolid solid = pseudo_solid(0.3, 1, 2);
  const auto element = simplex_geometry<D>(skewed, nodes);
  const double weight = stiffness_weight<D>(solid, element.jacobian);
  const Block some = Block::Random();
  const Block spin = some - some.transpose();
  for (int a = 0; a <= D; ++a) {
    Block sum = Block::Zero();
    Vector rotated = Vector::Zero();
    for (int b = 0; b <= D; ++b) {
      const Block K_ab = stiffness_block<D>(solid, element, weight, a, b);
      EXPECT_TRUE(K_ab.isApprox(stiffness_block<D>(solid, element, weight, b, a).transpose(), 1e-14));
      sum += K_ab;
      rotated += K_ab * spin * Eigen::Map<const Vector>(&skewed[3 * static_cast<std::size_t>(b)]);
    }
    EXPECT_LT(sum.norm(), 1e-14);
    EXPECT_LT(rotated.norm(), 1e-14);
  }
}

TEST(PseudoSolid, BlocksAreSymmetricAndFreeOfRigidMotions) {
  expect_symmetric_blocks_without_rigid_motions<2>();
  expect_symmetric_blocks_without_rigid_motions<3>();
}

// The energy of a uniform strain is volume times (lambda tr^2 + 2 mu eps:eps) / 2.
template <int D>
void expect_energy_of_a_uniform_strain() {
  using Vector = Eigen::Matrix<double, D, 1>;
  const PseudoSolid solid = pseudo_solid(0.3, 0, 1);
  EXPECT_NEAR(solid.mu, 1 / 2.6, 1e-15);
  EXPECT_NEAR(solid.lambda, 0.3 / (1.3 * 0.4), 1e-15);
  const auto element = simplex_geometry<D>(skewed, nodes);
  const double weight = stiffness_weight<D>(solid, element.jacobian);
  Eigen::Matrix3d whole;
  whole << 0.1, 0.02, -0.03, 0.02, -0.2, 0.05, -0.03, 0.05, 0.04;
  const Eigen::Matrix<double, D, D> strain = whole.topLeftCorner<D, D>();
  double energy = 0;
  for (int a = 0; a <= D; ++a)
    for (int b = 0; b <= D; ++b) {
      const Eigen::Map<const Vector> X_a(&skewed[3 * static_cast<std::size_t>(a)]);
      const Eigen::Map<const Vector> X_b(&skewed[3 * static_cast<std::size_t>(b)]);
      energy += 0.5 * (strain * X_a).dot(stiffness_block<D>(solid, element, weight, a, b) * (strain * X_b));
    }
  const double density =
      0.5 * solid.lambda * strain.trace() * strain.trace() + solid.mu * strain.squaredNorm();
  EXPECT_NEAR(energy, density * element.jacobian / (D == 2 ? 2 : 6), 1e-14);
}

TEST(PseudoSolid, EnergyOfAUniformStrain) {
  expect_energy_of_a_uniform_strain<2>();
  expect_energy_of_a_uniform_strain<3>();
}

TEST(PseudoSolid, StiffeningDividesByTheJacobianToAPower) {
  EXPECT_DOUBLE_EQ(stiffness_weight<3>(pseudo_solid(0.3, 0, 5), 0.6), 0.1);
  EXPECT_DOUBLE_EQ(stiffness_weight<3>(pseudo_solid(0.3, 1, 5), 0.6), 5.0 / 6);
  EXPECT_DOUBLE_EQ(stiffness_weight<3>(pseudo_solid(0.3, 2, 6), 0.6), 10.0);
  EXPECT_DOUBLE_EQ(stiffness_weight<2>(pseudo_solid(0.3, 1, 5), 0.6), 5.0 / 2);
}

TEST(Quality, RegularSimplicesHaveMeanRatioOne) {
  const std::vector<double> tet = {1, 1, 1, -1, 1, -1, 1, -1, -1, -1, -1, 1};
  EXPECT_NEAR(cell_shape(3, tet, nodes).mean_ratio, 1, 1e-14);
  EXPECT_NEAR(cell_shape(3, tet, nodes).cosine, 1.0 / 3, 1e-14); // 70.5 degrees
  const std::vector<double> triangle = {0, 0, 5, 2, 0, 5, 1, std::numbers::sqrt3, 5};
  EXPECT_NEAR(cell_shape(2, triangle, std::vector<std::int32_t>{0, 1, 2}).mean_ratio, 1, 1e-14);
  EXPECT_NEAR(cell_shape(2, triangle, std::vector<std::int32_t>{0, 1, 2}).cosine, 0.5, 1e-14);
}

TEST(Quality, ShapeOfTheUnitCorner) {
  const CellShape tet = cell_shape(3, corner, nodes);
  EXPECT_NEAR(tet.mean_ratio, 12 * std::pow(0.5, 2.0 / 3) / 9, 1e-14); // 12 (1/2)^(2/3) / (3 * 1 + 3 * 2)
  EXPECT_NEAR(tet.aspect, std::pow(2, 1.5), 1e-14);
  EXPECT_NEAR(tet.cosine, 1 / std::numbers::sqrt3, 1e-14);
  const CellShape triangle = cell_shape(2, corner, nodes);
  EXPECT_NEAR(triangle.mean_ratio, std::numbers::sqrt3 / 2, 1e-14); // 4 sqrt(3) (1/2) / (1 + 1 + 2)
  EXPECT_NEAR(triangle.aspect, 2, 1e-14);
  EXPECT_NEAR(triangle.cosine, 1 / std::numbers::sqrt2, 1e-14);
  const CellShape inverted = cell_shape(3, corner, std::vector<std::int32_t>{1, 0, 2, 3});
  EXPECT_EQ(inverted.mean_ratio, 0);
  EXPECT_EQ(inverted.cosine, 1);
}

TEST(Quality, FindsTheWorstElement) {
  std::vector<double> points = corner;
  points.insert(points.end(), {1, 1, 1});
  const Cells cells = {3, {0, 1, 2, 3, 1, 2, 3, 4}};
  const auto initial = initial_shapes(points, cells);
  ASSERT_TRUE(initial.ok());
  for (std::size_t c = 12; c < 15; ++c) points[c] = 0.5; // flattens the second
  const Quality quality = assess(points, cells, *initial);
  EXPECT_EQ(quality.min_volume_element, 1);
  EXPECT_EQ(quality.worst_element, 1);
  EXPECT_EQ(quality.f_AR_element, 1);
  EXPECT_NEAR(quality.min_volume_ratio, 0.25, 1e-14); // (3/2 - 1) / (3 - 1)
  EXPECT_DOUBLE_EQ(quality.max_volume_ratio, 1);
  EXPECT_NEAR(quality.worst_place[0], 1.5 / 4, 1e-14);
  EXPECT_NEAR(quality.f_A, 2, 1e-14);  // log2 4
  EXPECT_NEAR(quality.f_AR, 2, 1e-14); // the longest edge stays
  EXPECT_EQ(broken_limit(quality, {.min_volume_ratio = 0.2}, cells, points), "");
  EXPECT_NE(broken_limit(quality, {.min_volume_ratio = 0.3}, cells, points).find("tetrahedron 1 at"),
            std::string::npos);
  EXPECT_NE(broken_limit(quality, {.f_A = 1.5}, cells, points).find("f_A"), std::string::npos);
  EXPECT_NE(broken_limit(quality, {.f_AR = 1.5}, cells, points).find("f_AR"), std::string::npos);
  EXPECT_NE(broken_limit(quality, {.mean_ratio = 0.9}, cells, points).find("mean ratio"), std::string::npos);
  EXPECT_NE(broken_limit(quality, {.angle = 60}, cells, points).find("angle"), std::string::npos);
}

// An element blown up counts as much as one that shrinks.
TEST(Quality, ChangesCountInBothDirections) {
  const Cells cells = {2, {0, 1, 2}};
  auto points = corner;
  const auto initial = initial_shapes(std::span(points).first(9), cells);
  ASSERT_TRUE(initial.ok());
  for (double& x : points) x *= 4;
  const Quality quality = assess(points, cells, *initial);
  EXPECT_NEAR(quality.f_A, 4, 1e-14);
  EXPECT_NEAR(quality.f_AR, 0, 1e-14);
  EXPECT_NEAR(quality.smallest_angle, 45, 1e-12);
}

TEST(Quality, PercentilesOfTheElements) {
  // 101 triangles on a common base; triangle k has the height 1 + k.
  std::vector<double> points = {0, 0, 0, 1, 0, 0};
  Cells cells{2, {}};
  for (std::int32_t k = 0; k <= 100; ++k) {
    points.insert(points.end(), {0, 1.0 + k, 0});
    cells.nodes.insert(cells.nodes.end(), {0, 1, k + 2});
  }
  const Distribution d = distribution(points, cells);
  const auto angle = [](double height) { return std::atan(1 / height) * 180 / std::numbers::pi; };
  EXPECT_NEAR(d.angle.p1, angle(100), 1e-9);
  EXPECT_NEAR(d.angle.p10, angle(91), 1e-9);
  EXPECT_NEAR(d.angle.p50, angle(51), 1e-9);
  const auto mean_ratio = [](double height) {
    return 2 * std::numbers::sqrt3 * height / (1 + height * height + 1 + height * height);
  };
  EXPECT_NEAR(d.mean_ratio.p50, mean_ratio(51), 1e-12);
}

TEST(Quality, RefusesANodeWithoutElement) {
  const auto refused = initial_shapes(corner, Cells{2, {0, 1, 2}});
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("node 3 at (0, 0, 1)"), std::string::npos)
      << refused.error().message;
}

} // namespace
} // namespace drogue::mesh_mover
