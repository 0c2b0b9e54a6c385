// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/shape.hpp"

#include <gtest/gtest.h>

#include <array>
#include <numeric>
#include <vector>

namespace drogue::fem {
namespace {

using mesh::ElementKind;
using Point = std::array<double, 2>;

/// Parent coordinates of the nodes in Gmsh's order, written down independently of the shape functions.
std::vector<Point> nodes_of(ElementKind kind) {
  std::vector<Point> nodes = is_quadrilateral(kind) ? std::vector<Point>{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}
                                                    : std::vector<Point>{{0, 0}, {1, 0}, {0, 1}};
  const std::size_t corners = nodes.size();
  if (kind == ElementKind::tri3 || kind == ElementKind::quad4) return nodes;
  for (std::size_t a = 0; a < corners; ++a) {
    const Point p = nodes[a], q = nodes[(a + 1) % corners];
    nodes.push_back({0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])});
  }
  if (kind == ElementKind::quad9) nodes.push_back({0, 0});
  return nodes;
}

constexpr std::array<Point, 4> samples = {{{0.2, 0.3}, {0.7, 0.1}, {-0.4, 0.9}, {0.05, -0.6}}};

class SurfaceShapes : public testing::TestWithParam<ElementKind> {};

TEST_P(SurfaceShapes, AreOneAtTheirNodeAndZeroAtTheOthers) {
  const auto nodes = nodes_of(GetParam());
  ASSERT_EQ(static_cast<int>(nodes.size()), mesh::nodes_per_element(GetParam()));
  for (std::size_t b = 0; b < nodes.size(); ++b) {
    const SurfaceShape s = surface_shape(GetParam(), nodes[b][0], nodes[b][1]);
    EXPECT_EQ(s.nodes, static_cast<int>(nodes.size()));
    for (std::size_t a = 0; a < nodes.size(); ++a)
      EXPECT_NEAR(s.N[a], a == b ? 1 : 0, 1e-15) << a << " at " << b;
  }
}

TEST_P(SurfaceShapes, SumToOneAndTheirDerivativesToZero) {
  for (const auto& [xi, eta] : samples) {
    const SurfaceShape s = surface_shape(GetParam(), xi, eta);
    EXPECT_NEAR(std::accumulate(s.N.begin(), s.N.end(), 0.0), 1, 1e-15);
    EXPECT_NEAR(std::accumulate(s.dN_dxi.begin(), s.dN_dxi.end(), 0.0), 0, 1e-14);
    EXPECT_NEAR(std::accumulate(s.dN_deta.begin(), s.dN_deta.end(), 0.0), 0, 1e-14);
  }
}

/// Central differences are exact for the polynomials of second degree that these are along each coordinate.
TEST_P(SurfaceShapes, DerivativesAgreeWithDifferences) {
  constexpr double h = 1e-3;
  for (const auto& [xi, eta] : samples) {
    const SurfaceShape s = surface_shape(GetParam(), xi, eta);
    const SurfaceShape east = surface_shape(GetParam(), xi + h, eta),
                       west = surface_shape(GetParam(), xi - h, eta);
    const SurfaceShape north = surface_shape(GetParam(), xi, eta + h),
                       south = surface_shape(GetParam(), xi, eta - h);
    for (std::size_t a = 0; a < static_cast<std::size_t>(s.nodes); ++a) {
      EXPECT_NEAR(s.dN_dxi[a], (east.N[a] - west.N[a]) / (2 * h), 1e-12) << a;
      EXPECT_NEAR(s.dN_deta[a], (north.N[a] - south.N[a]) / (2 * h), 1e-12) << a;
    }
  }
}

/// Every element holds linear functions; those of second order hold quadratic ones, the quadrilaterals xi eta
/// as well.
TEST_P(SurfaceShapes, ReproducePolynomials) {
  const bool quadratic = GetParam() == ElementKind::tri6 || GetParam() == ElementKind::quad9;
  const auto f = [&](const Point& p) {
    const double linear = 1 + 2 * p[0] - 3 * p[1];
    const double bilinear = is_quadrilateral(GetParam()) ? 4 * p[0] * p[1] : 0;
    return linear + bilinear + (quadratic ? p[0] * p[0] - 5 * p[1] * p[1] + 0.5 * p[0] * p[1] : 0);
  };
  const auto nodes = nodes_of(GetParam());
  for (const Point& p : samples) {
    const SurfaceShape s = surface_shape(GetParam(), p[0], p[1]);
    double interpolated = 0;
    for (std::size_t a = 0; a < nodes.size(); ++a) interpolated += s.N[a] * f(nodes[a]);
    EXPECT_NEAR(interpolated, f(p), 1e-13);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, SurfaceShapes,
                         testing::Values(ElementKind::tri3, ElementKind::tri6, ElementKind::quad4,
                                         ElementKind::quad9),
                         [](const auto& kind) {
                           return "nodes" + std::to_string(static_cast<int>(kind.param));
                         });

class VolumeShapes : public testing::TestWithParam<ElementKind> {};

constexpr std::array<std::array<double, 3>, 3> volume_samples = {
    {{0.2, 0.3, 0.1}, {0.1, 0.6, -0.5}, {-0.4, 0.05, 0.7}}};

TEST_P(VolumeShapes, AreOneAtTheirNodeAndZeroAtTheOthers) {
  const int n = mesh::nodes_per_element(GetParam());
  for (int b = 0; b < n; ++b) {
    const VolumeShape s = volume_shape(GetParam(), volume_node(GetParam(), b));
    EXPECT_EQ(s.nodes, n);
    for (int a = 0; a < n; ++a)
      EXPECT_NEAR(s.N[static_cast<std::size_t>(a)], a == b ? 1 : 0, 1e-15) << a << " at " << b;
  }
}

TEST_P(VolumeShapes, DerivativesAgreeWithDifferencesAndSumToZero) {
  constexpr double h = 1e-3;
  for (const auto& xi : volume_samples) {
    const VolumeShape s = volume_shape(GetParam(), xi);
    EXPECT_NEAR(std::accumulate(s.N.begin(), s.N.end(), 0.0), 1, 1e-14);
    for (std::size_t k = 0; k < 3; ++k) {
      auto plus = xi, minus = xi;
      plus[k] += h;
      minus[k] -= h;
      const VolumeShape p = volume_shape(GetParam(), plus), m = volume_shape(GetParam(), minus);
      EXPECT_NEAR(std::accumulate(s.dN[k].begin(), s.dN[k].end(), 0.0), 0, 1e-14);
      for (std::size_t a = 0; a < static_cast<std::size_t>(s.nodes); ++a)
        EXPECT_NEAR(s.dN[k][a], (p.N[a] - m.N[a]) / (2 * h), 1e-12) << a;
    }
  }
}

TEST_P(VolumeShapes, ReproducePolynomials) {
  const bool quadratic = GetParam() != ElementKind::tet4;
  const auto f = [&](const std::array<double, 3>& p) {
    return 1 + 2 * p[0] - 3 * p[1] + p[2] +
           (quadratic ? p[0] * p[0] - 5 * p[1] * p[2] + 0.5 * p[2] * p[0] : 0);
  };
  for (const auto& xi : volume_samples) {
    const VolumeShape s = volume_shape(GetParam(), xi);
    double interpolated = 0;
    for (int a = 0; a < s.nodes; ++a)
      interpolated += s.N[static_cast<std::size_t>(a)] * f(volume_node(GetParam(), a));
    EXPECT_NEAR(interpolated, f(xi), 1e-13);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, VolumeShapes,
                         testing::Values(ElementKind::tet4, ElementKind::tet10, ElementKind::hex27),
                         [](const auto& kind) {
                           return "nodes" + std::to_string(mesh::nodes_per_element(kind.param));
                         });

TEST(LineShapes, InterpolateAndDifferentiate) {
  for (const ElementKind kind : {ElementKind::line2, ElementKind::line3}) {
    constexpr double node[3] = {-1, 1, 0}, h = 1e-3;
    for (int b = 0; b < mesh::nodes_per_element(kind); ++b) {
      const LineShape s = line_shape(kind, node[b]), p = line_shape(kind, node[b] + h),
                      m = line_shape(kind, node[b] - h);
      for (int a = 0; a < s.nodes; ++a) {
        const auto i = static_cast<std::size_t>(a);
        EXPECT_NEAR(s.N[i], a == b ? 1 : 0, 1e-15);
        EXPECT_NEAR(s.dN_dxi[i], (p.N[i] - m.N[i]) / (2 * h), 1e-12);
      }
    }
  }
}

TEST(ParentCentre, LiesInTheMiddle) {
  EXPECT_EQ(parent_centre(ElementKind::quad9), (Point{0, 0}));
  EXPECT_EQ(parent_centre(ElementKind::tri6), (Point{1.0 / 3, 1.0 / 3}));
}

} // namespace
} // namespace drogue::fem
