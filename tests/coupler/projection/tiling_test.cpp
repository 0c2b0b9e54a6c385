// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "coupler/projection/element_matrix.hpp"
#include "coupler/projection/triangle_tiling.hpp"
#include "surfaces.hpp"

namespace drogue::projection::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Triangle big{Vector3d(0, 0, 0), Vector3d(2, 0.3, 0), Vector3d(0.2, 1.5, 0)};

/// int N_a of `inner` times N_b of `outer`, by quadrature on `inner`, which lies within.
Matrix3d by_points(const Triangle& outer, const Triangle& inner) {
  Eigen::Matrix2d J;
  J << (outer[1] - outer[0]).head<2>(), (outer[2] - outer[0]).head<2>();
  const double area = (inner[1] - inner[0]).cross(inner[2] - inner[0]).norm();
  Matrix3d sum = Matrix3d::Zero();
  for (const auto& q : element_quadrature(ElementKind::tri3, 4)) {
    const Vector3d N(1 - q.xi - q.eta, q.xi, q.eta);
    const Vector3d x = N[0] * inner[0] + N[1] * inner[1] + N[2] * inner[2];
    const Eigen::Vector2d s = J.inverse() * (x - outer[0]).head<2>();
    sum += q.weight * area * N * Eigen::RowVector3d(1 - s[0] - s[1], s[0], s[1]);
  }
  return sum;
}

TEST(TriangleOverlap, IntegratesOverATriangleWithin) {
  const Triangle inner{Vector3d(0.3, 0.2, 0.01), Vector3d(0.9, 0.3, 0.01), Vector3d(0.4, 0.8, 0.01)};
  const TriangleFrame frame(big);
  const Overlap o = frame.overlap(inner);
  EXPECT_EQ(o.corners, 3);
  EXPECT_EQ(o.sense, 1);
  EXPECT_NEAR(o.gap, 0.01, 1e-15);
  EXPECT_NEAR(frame.jacobian() * o.area, 0.5 * (inner[1] - inner[0]).cross(inner[2] - inner[0]).norm(),
              1e-15);
  EXPECT_LT((frame.jacobian() * o.cross - by_points(big, inner)).norm(), 1e-15);
  EXPECT_NEAR(o.own.sum(), o.area, 1e-15);
  EXPECT_LT((o.own.rowwise().sum() - o.cross.rowwise().sum()).norm(), 1e-15); // int N_a, twice
  const Overlap turned = frame.overlap({inner[0], inner[2], inner[1]});
  EXPECT_EQ(turned.sense, -1);
  EXPECT_NEAR(turned.area, o.area, 1e-16);
  EXPECT_LT((turned.cross.row(1) - o.cross.row(2)).norm(), 1e-15);
}

TEST(TriangleOverlap, IsTheSameFromBothSides) {
  int overlapping = 0;
  for (int i = 0; i < 200; ++i) {
    Triangle other;
    for (int a = 0; a < 3; ++a)
      other[static_cast<std::size_t>(a)] = {1 + 1.6 * std::sin(3.1 * i + 2 * a),
                                            0.8 + 1.6 * std::cos(1.7 * i + 5 * a), 0};
    const TriangleFrame one(big), two(other);
    const Overlap from_one = one.overlap(other), from_two = two.overlap(big);
    if (from_one.sense == 0 || from_two.sense == 0) continue; // slivers
    EXPECT_EQ(from_one.sense, from_two.sense);
    EXPECT_EQ(from_one.corners, from_two.corners);
    if (from_one.corners == 0) continue;
    ++overlapping;
    EXPECT_NEAR(one.jacobian() * from_one.area, two.jacobian() * from_two.area, 1e-13);
    EXPECT_LT((one.jacobian() * from_one.cross - two.jacobian() * from_two.cross.transpose()).norm(), 1e-12);
  }
  EXPECT_GT(overlapping, 50);
}

TEST(TriangleOverlap, IsNothingBesideAndOnEdge) {
  const TriangleFrame frame(big);
  EXPECT_EQ(frame.overlap({Vector3d(3, 3, 0), Vector3d(4, 3, 0), Vector3d(3, 4, 0)}).corners, 0);
  const Overlap upright =
      frame.overlap({Vector3d(0.3, 0.3, 0), Vector3d(0.6, 0.3, 0), Vector3d(0.3, 0.3, 1)});
  EXPECT_EQ(upright.sense, 0);
  EXPECT_EQ(upright.corners, 0);
}

struct Tiled {
  explicit Tiled(Surface s)
      : surface(std::move(s)), elements(surface), tiling(elements, surface.points, surface.node_count()) {}
  bool cover(const Triangle& t, double largest_gap = 1) {
    std::int32_t seed = 0; // the nearest centre
    double nearest = 1e9;
    for (std::int32_t e = 0; e < elements.count(); ++e) {
      const Triangle X = tiling.corners(e);
      const double d = ((X[0] + X[1] + X[2]) - (t[0] + t[1] + t[2])).norm();
      if (d < nearest) seed = e, nearest = d;
    }
    return tiling.cover(TriangleFrame(t), seed, largest_gap);
  }
  Surface surface;
  Elements elements;
  TriangleTiling tiling;
};

TEST(TriangleTiling, TheTilesAddUpToTheTriangle) {
  Tiled plate9(plate(ElementKind::tri3, 9));
  ASSERT_TRUE(plate9.cover({Vector3d(0.1, 0.2, 0.1), Vector3d(0.9, 0.3, 0.1), Vector3d(0.4, 0.8, 0.1)}));
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (const auto& tile : plate9.tiling.tiles()) sum += tile.overlap.cross.colwise().sum();
  EXPECT_LT((sum - Eigen::RowVector3d::Constant(1.0 / 6)).norm(), 1e-15);
  EXPECT_GT(plate9.tiling.tiles().size(), 20u);
}

TEST(TriangleTiling, RefusesFreeEdgesGapsAndFolds) {
  Tiled flat(plate(ElementKind::tri3, 4));
  EXPECT_FALSE(flat.cover({Vector3d(0.5, 0.5, 0), Vector3d(1.2, 0.5, 0), Vector3d(0.5, 0.9, 0)}));
  EXPECT_FALSE(flat.cover({Vector3d(0.2, 0.2, 0.3), Vector3d(0.4, 0.2, 0.3), Vector3d(0.2, 0.4, 0.3)}, 0.2));
  EXPECT_TRUE(flat.cover({Vector3d(0.2, 0.2, 0.3), Vector3d(0.4, 0.2, 0.3), Vector3d(0.2, 0.4, 0.3)}, 0.4));
  const auto folded = [](double x, double y) { return Point{std::min(x, 1.3 - x), y, x < 0.65 ? 0 : 0.01}; };
  Tiled fold(grid(ElementKind::tri3, 8, folded));
  EXPECT_FALSE(fold.cover({Vector3d(0.5, 0.3, 0), Vector3d(0.64, 0.3, 0), Vector3d(0.5, 0.5, 0)}));
}

/// Two plates one above the other: only the one under the seed takes part.
TEST(TriangleTiling, StaysOnItsSheet) {
  Surface above = plate(ElementKind::tri3, 5);
  for (std::size_t i = 2; i < above.points.size(); i += 3) above.points[i] = 0.01;
  Tiled two(combine_surfaces(plate(ElementKind::tri3, 5), above));
  ASSERT_TRUE(two.cover({Vector3d(0.1, 0.1, 0.001), Vector3d(0.7, 0.1, 0.001), Vector3d(0.1, 0.7, 0.001)}));
  for (const auto& tile : two.tiling.tiles()) EXPECT_LT(tile.element, 50);
}

TEST(SumElements, AddsWhatOverlapsInSortedRows) {
  const std::vector<std::int32_t> nodes{0, 2, 1, 2};
  const std::vector<double> values{1, 2, 3, 4, 10, 20, 30, 40};
  const auto nodes_of = [&](std::int32_t e) {
    return std::span(nodes).subspan(2 * static_cast<std::size_t>(e), 2);
  };
  const Adjacency around = elements_around(3, 2, nodes_of);
  EXPECT_EQ(around.around(2).size(), 2u);
  const auto part = [&](std::int32_t e) {
    return ElementPart{nodes_of(e), nodes_of(e), values.data() + 4 * e, 2, 1, 0.5};
  };
  const Matrix3d full(sum_elements(3, 3, around, part));
  EXPECT_EQ(full, (Matrix3d() << 0.5, 0, 1, 0, 5, 10, 1.5, 15, 22).finished());
  const la::SparseMatrix upper = upper_triangle(sum_elements(3, 3, around, part, true));
  EXPECT_EQ(Matrix3d(upper), (Matrix3d() << 0.5, 0, 1.5, 0, 5, 15, 0, 0, 22).finished());
}

/// Clusters of nodes at the corners of the grid of cells, where one must look into eight of them.
TEST(MergeCoincident, LooksBeyondTheBordersOfItsCells) {
  std::vector<double> x;
  for (int i = 0; i < 350; ++i)
    for (int k = 0; k < 3; ++k)
      x.push_back(4096e-6 * (i % 7) * (k + 1) + 0.25e-6 * std::sin(1.0 * i * (k + 1)));
  const Merged merged = merge_coincident(x, 1e-6);
  EXPECT_EQ(merged.count, 7);
  for (std::size_t i = 0; i < 350; ++i) EXPECT_EQ(merged.group[i], static_cast<std::int32_t>(i % 7));
}

} // namespace
} // namespace drogue::projection::test
