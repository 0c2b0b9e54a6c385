// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/pseudo_solid.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "mesh_mover/quality.hpp"

namespace drogue::mesh_mover {
namespace {

const std::vector<double> corner = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
const std::vector<double> skewed = {0.1, 0, 0.2, 1.3, 0.1, 0, 0.2, 0.9, 0.1, -0.1, 0.3, 1.4};
const std::vector<std::int32_t> nodes = {0, 1, 2, 3};

TEST(PseudoSolid, GeometryOfTheUnitCorner) {
  const TetGeometry element = tet_geometry(corner, nodes);
  EXPECT_DOUBLE_EQ(element.jacobian, 1);
  Eigen::Matrix<double, 3, 4> expected;
  expected << -1, 1, 0, 0, -1, 0, 1, 0, -1, 0, 0, 1;
  EXPECT_TRUE(element.gradients.isApprox(expected));
}

TEST(PseudoSolid, BlocksAreSymmetricAndFreeOfRigidMotions) {
  const PseudoSolid solid = pseudo_solid(0.3, 1, 2);
  const TetGeometry element = tet_geometry(skewed, nodes);
  const double weight = stiffness_weight(solid, element.jacobian);
  const Eigen::Vector3d omega(0.3, -0.2, 0.7);
  for (int a = 0; a < 4; ++a) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    Eigen::Vector3d rotated = Eigen::Vector3d::Zero();
    for (int b = 0; b < 4; ++b) {
      const Eigen::Matrix3d K_ab = stiffness_block(solid, element, weight, a, b);
      EXPECT_TRUE(K_ab.isApprox(stiffness_block(solid, element, weight, b, a).transpose(), 1e-14));
      sum += K_ab;
      rotated +=
          K_ab * omega.cross(Eigen::Map<const Eigen::Vector3d>(&skewed[3 * static_cast<std::size_t>(b)]));
    }
    EXPECT_LT(sum.norm(), 1e-14);
    EXPECT_LT(rotated.norm(), 1e-14);
  }
}

// The energy of a uniform strain is volume times (lambda tr^2 + 2 mu eps:eps) / 2.
TEST(PseudoSolid, EnergyOfAUniformStrain) {
  const PseudoSolid solid = pseudo_solid(0.3, 0, 1);
  EXPECT_NEAR(solid.mu, 1 / 2.6, 1e-15);
  EXPECT_NEAR(solid.lambda, 0.3 / (1.3 * 0.4), 1e-15);
  const TetGeometry element = tet_geometry(skewed, nodes);
  const double weight = stiffness_weight(solid, element.jacobian);
  Eigen::Matrix3d strain;
  strain << 0.1, 0.02, -0.03, 0.02, -0.2, 0.05, -0.03, 0.05, 0.04;
  double energy = 0;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) {
      const Eigen::Map<const Eigen::Vector3d> X_a(&skewed[3 * static_cast<std::size_t>(a)]);
      const Eigen::Map<const Eigen::Vector3d> X_b(&skewed[3 * static_cast<std::size_t>(b)]);
      energy += 0.5 * (strain * X_a).dot(stiffness_block(solid, element, weight, a, b) * (strain * X_b));
    }
  const double density =
      0.5 * solid.lambda * strain.trace() * strain.trace() + solid.mu * strain.squaredNorm();
  EXPECT_NEAR(energy, density * element.jacobian / 6, 1e-14);
}

TEST(PseudoSolid, StiffeningDividesByTheJacobianToAPower) {
  EXPECT_DOUBLE_EQ(stiffness_weight(pseudo_solid(0.3, 0, 5), 0.6), 0.1);
  EXPECT_DOUBLE_EQ(stiffness_weight(pseudo_solid(0.3, 1, 5), 0.6), 5.0 / 6);
  EXPECT_DOUBLE_EQ(stiffness_weight(pseudo_solid(0.3, 2, 6), 0.6), 10.0);
}

TEST(Quality, MeanRatio) {
  const std::vector<double> regular = {1, 1, 1, -1, 1, -1, 1, -1, -1, -1, -1, 1};
  EXPECT_NEAR(mean_ratio(regular, nodes), 1, 1e-14);
  // 12 (1/2)^(2/3) / (3 * 1 + 3 * 2)
  EXPECT_NEAR(mean_ratio(corner, nodes), 12 * std::pow(0.5, 2.0 / 3) / 9, 1e-14);
  EXPECT_EQ(mean_ratio(corner, std::vector<std::int32_t>{1, 0, 2, 3}), 0);
}

TEST(Quality, FindsTheWorstElement) {
  std::vector<double> points = corner;
  points.insert(points.end(), {1, 1, 1});
  const std::vector<std::int32_t> tets = {0, 1, 2, 3, 1, 2, 3, 4};
  const auto jacobians = positive_jacobians(points, tets);
  ASSERT_TRUE(jacobians.ok());
  for (std::size_t c = 12; c < 15; ++c) points[c] = 0.5; // flattens the second
  const Quality quality = assess(points, tets, *jacobians);
  EXPECT_EQ(quality.min_volume_element, 1);
  EXPECT_EQ(quality.worst_element, 1);
  EXPECT_NEAR(quality.min_volume_ratio, 0.25, 1e-14); // (3/2 - 1) / (3 - 1)
  EXPECT_DOUBLE_EQ(quality.max_volume_ratio, 1);
  EXPECT_NEAR(quality.worst_place[0], 1.5 / 4, 1e-14);
  EXPECT_TRUE(accept(quality, 0.2).ok());
  EXPECT_FALSE(accept(quality, 0.3).ok());
}

} // namespace
} // namespace drogue::mesh_mover
