// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/quadrature.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace drogue::fem {
namespace {

using mesh::ElementKind;

double integrate(const std::vector<SurfacePoint>& rule, int i, int j) {
  double sum = 0;
  for (const SurfacePoint& p : rule) sum += p.weight * std::pow(p.xi, i) * std::pow(p.eta, j);
  return sum;
}

/// Integral of xi^i eta^j over the triangle (0,0), (1,0), (0,1): i! j! / (i + j + 2)!.
double exact_triangle(int i, int j) {
  return std::exp(std::lgamma(i + 1) + std::lgamma(j + 1) - std::lgamma(i + j + 3));
}

/// Integral of s^i over [-1, 1].
double exact_line(int i) {
  return i % 2 == 0 ? 2.0 / (i + 1) : 0;
}

class Degrees : public testing::TestWithParam<int> {};

TEST_P(Degrees, TriangleIsExactUpToTheDegree) {
  const int degree = GetParam();
  const auto rule = surface_quadrature(ElementKind::tri3, degree);
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; i + j <= degree; ++j)
      EXPECT_NEAR(integrate(rule, i, j), exact_triangle(i, j), 1e-14) << "xi^" << i << " eta^" << j;
}

TEST_P(Degrees, QuadrilateralIsExactUpToTheDegreeInEachCoordinate) {
  const int degree = GetParam();
  const auto rule = surface_quadrature(ElementKind::quad9, degree);
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; j <= degree; ++j)
      EXPECT_NEAR(integrate(rule, i, j), exact_line(i) * exact_line(j), 1e-13) << "xi^" << i << " eta^" << j;
}

TEST_P(Degrees, PointsLieInsideAndWeightsArePositive) {
  for (const SurfacePoint& p : surface_quadrature(ElementKind::tri6, GetParam())) {
    EXPECT_GT(p.weight, 0);
    EXPECT_GT(p.xi, 0);
    EXPECT_GT(p.eta, 0);
    EXPECT_LT(p.xi + p.eta, 1);
  }
  for (const SurfacePoint& p : surface_quadrature(ElementKind::quad4, GetParam())) {
    EXPECT_GT(p.weight, 0);
    EXPECT_LT(std::abs(p.xi), 1);
    EXPECT_LT(std::abs(p.eta), 1);
  }
}

INSTANTIATE_TEST_SUITE_P(Quadrature, Degrees, testing::Range(1, 21));

double integrate(const std::vector<VolumePoint>& rule, int i, int j, int k) {
  double sum = 0;
  for (const VolumePoint& p : rule)
    sum += p.weight * std::pow(p.xi[0], i) * std::pow(p.xi[1], j) * std::pow(p.xi[2], k);
  return sum;
}

TEST(VolumeQuadrature, TetrahedronIsExactUpToTheDegree) {
  for (int degree = 1; degree <= 5; ++degree) {
    const auto rule = volume_quadrature(ElementKind::tet10, degree);
    EXPECT_EQ(rule.size(), degree == 1 ? 1U : degree == 2 ? 4U : 14U);
    for (int i = 0; i <= degree; ++i)
      for (int j = 0; i + j <= degree; ++j)
        for (int k = 0; i + j + k <= degree; ++k) {
          // i! j! k! / (i + j + k + 3)!
          const double exact = std::exp(std::lgamma(i + 1) + std::lgamma(j + 1) + std::lgamma(k + 1) -
                                        std::lgamma(i + j + k + 4));
          EXPECT_NEAR(integrate(rule, i, j, k), exact, 1e-15) << i << j << k << " degree " << degree;
        }
    for (const VolumePoint& p : rule) {
      EXPECT_GT(p.weight, 0);
      EXPECT_GT(std::min({p.xi[0], p.xi[1], p.xi[2]}), 0);
      EXPECT_LT(p.xi[0] + p.xi[1] + p.xi[2], 1);
    }
  }
}

TEST(VolumeQuadrature, HexahedronIsExactUpToTheDegreeInEachCoordinate) {
  const auto rule = volume_quadrature(ElementKind::hex27, 5);
  EXPECT_EQ(rule.size(), 27U);
  for (int i = 0; i <= 5; ++i)
    for (int j = 0; j <= 5; ++j)
      for (int k = 0; k <= 5; ++k)
        EXPECT_NEAR(integrate(rule, i, j, k), exact_line(i) * exact_line(j) * exact_line(k), 1e-13);
}

TEST(Quadrature, TriangleRulesAreTheSmallOnes) {
  const std::size_t counts[] = {1, 3, 6, 6, 7};
  for (int degree = 1; degree <= 5; ++degree)
    EXPECT_EQ(surface_quadrature(ElementKind::tri3, degree).size(), counts[degree - 1]) << degree;
}

TEST(Quadrature, ARuleIsNotExactMuchBeyondItsDegree) {
  EXPECT_GT(std::abs(integrate(surface_quadrature(ElementKind::tri3, 2), 3, 1) - exact_triangle(3, 1)), 1e-6);
  EXPECT_GT(std::abs(integrate(surface_quadrature(ElementKind::quad4, 3), 4, 0) - 2 * exact_line(4)), 1e-3);
}

TEST(GaussLegendre, IsExactToDegreeTwoNMinusOne) {
  for (int n = 1; n <= 32; ++n) {
    const GaussRule rule = gauss_legendre(n);
    ASSERT_EQ(rule.points.size(), static_cast<std::size_t>(n));
    for (int degree = 0; degree <= 2 * n - 1; ++degree) {
      double sum = 0;
      for (std::size_t q = 0; q < rule.points.size(); ++q)
        sum += rule.weights[q] * std::pow(rule.points[q], degree);
      EXPECT_NEAR(sum, exact_line(degree), 1e-13) << n << " points, degree " << degree;
    }
  }
}

} // namespace
} // namespace drogue::fem
