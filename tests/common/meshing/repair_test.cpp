// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/repair.hpp"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "common/meshing/checks.hpp"
#include "common/meshing/node_doubling.hpp"
#include "common/meshing/quality.hpp"
#include "tests/common/meshing/kuhn_grid.hpp"

namespace drogue::meshing {
namespace {

int spanning(const TetMesh& m) {
  std::set<std::int32_t> nodes;
  for (const Triangle& t : m.interior) nodes.insert(t.begin(), t.end());
  int count = 0;
  for (const Tet& tet : m.tets)
    count += nodes.count(tet[0]) + nodes.count(tet[1]) + nodes.count(tet[2]) + nodes.count(tet[3]) == 4;
  return count;
}

/// A floor and a wall that meet in a crease.
TetMesh folded_grid() {
  TetMesh m = kuhn_grid(6, 6, 6);
  m.interior = grid_faces(m, 2, [](const Point& x) {
    return std::abs(x.z() - 2) < 1e-9 && x.x() > 2 && x.x() < 4 && x.y() > 2 && x.y() < 4;
  });
  const std::vector<Triangle> wall = grid_faces(m, 0, [](const Point& x) {
    return std::abs(x.x() - 4) < 1e-9 && x.y() > 2 && x.y() < 4 && x.z() > 2 && x.z() < 4;
  });
  for (const Triangle& t : wall) m.interior.push_back({t[0], t[2], t[1]});
  m.interior = without_corners(m.interior);
  return m;
}

TEST(SplitBridges, LeavesNoTetWithAllNodesOnTheSurface) {
  TetMesh m = folded_grid();
  ASSERT_GT(spanning(m), 0);
  const int before = spanning(m);
  const std::vector<Triangle> surface = m.interior;
  const SplitSummary summary = split_bridges(m);
  EXPECT_EQ(summary.tets_before, before);
  EXPECT_GT(summary.edges_split, 0);
  EXPECT_EQ(spanning(m), 0);
  EXPECT_EQ(m.interior, surface);
  EXPECT_NEAR(summarise_quality(m.points, m.tets).total_volume, 216, 1e-11);
  ASSERT_TRUE(double_nodes(m, "upper", "lower").ok());
  const Result<void> checked = check_volume(m);
  EXPECT_TRUE(checked.ok()) << checked.error().message;
}

TEST(SplitBridges, SplitsATetWhoseEdgesAllLieOnTheSurface) {
  // Inside a fifth node's star: the four faces of an inner tet are reduced to the three that carry the
  // surface.
  TetMesh m;
  m.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  m.tets = {{0, 1, 2, 3}};
  m.interior = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}};
  const SplitSummary summary = split_bridges(m);
  EXPECT_EQ(summary.tets_split, 1);
  EXPECT_EQ(m.tets.size(), 4U);
  EXPECT_EQ(spanning(m), 0);
  const QualitySummary q = summarise_quality(m.points, m.tets);
  EXPECT_NEAR(q.total_volume, 1.0 / 6, 1e-15);
  EXPECT_NEAR(q.smallest_volume, 1.0 / 24, 1e-15);
}

TEST(SplitBridges, DoesNothingWithoutASurface) {
  TetMesh m = kuhn_grid(2, 2, 2);
  const std::vector<Tet> tets = m.tets;
  EXPECT_EQ(split_bridges(m).tets_before, 0);
  EXPECT_EQ(m.tets, tets);
}

TEST(SmoothBadTets, RepairsADisplacedNodeAndMovesNoOther) {
  TetMesh m = kuhn_grid(2, 2, 2);
  std::vector<Point> before = m.points;
  m.points[13] += Point(0.45, 0.4, -0.47); // the only inner node
  const double bad = summarise_quality(m.points, m.tets).smallest_mean_ratio;
  ASSERT_LT(bad, 0.35);
  EXPECT_GT(smooth_bad_tets(m, 0.5, 8), 0);
  EXPECT_GT(summarise_quality(m.points, m.tets).smallest_mean_ratio, 2 * bad);
  before[13] = m.points[13];
  EXPECT_EQ(m.points, before);
}

TEST(SmoothBadTets, KeepsNodesOfTheSurface) {
  TetMesh m = folded_grid();
  for (Point& x : m.points)
    if ((x - Point(3, 3, 3)).norm() < 0.1) x += Point(0.4, 0.45, -0.4);
  const std::vector<Point> before = m.points;
  EXPECT_GT(smooth_bad_tets(m, 0.5, 4), 0);
  for (const Triangle& t : m.interior)
    for (const std::int32_t node : t) {
      const auto i = static_cast<std::size_t>(node);
      EXPECT_EQ(m.points[i], before[i]);
    }
}

} // namespace
} // namespace drogue::meshing
