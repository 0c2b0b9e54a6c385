// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/node_doubling.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "common/meshing/checks.hpp"
#include "common/meshing/quality.hpp"
#include "tests/common/meshing/kuhn_grid.hpp"

namespace drogue::meshing {
namespace {

bool in_square(const Point& x, double low, double high) {
  return x.x() > low && x.x() < high && x.y() > low && x.y() < high;
}

bool at_height(const Point& x, double z) {
  return std::abs(x.z() - z) < 1e-9;
}

TEST(NodeDoubling, DoublesTheOneInnerNodeOfAPatch) {
  TetMesh m = kuhn_grid(4, 4, 2);
  m.interior =
      without_corners(grid_faces(m, 2, [](const Point& x) { return at_height(x, 1) && in_square(x, 1, 3); }));
  ASSERT_EQ(m.interior.size(), 6U);
  const std::size_t nodes = m.points.size();
  const Result<DoublingSummary> done = double_nodes(m, "upper", "lower");
  ASSERT_TRUE(done.ok()) << done.error().message;
  EXPECT_EQ(done->doubled_nodes, 1);
  EXPECT_EQ(done->single_nodes, 6);
  ASSERT_EQ(m.points.size(), nodes + 1);
  EXPECT_EQ(m.points.back(), Point(2, 2, 1));
  EXPECT_EQ(m.points[static_cast<std::size_t>(done->origin.back())], Point(2, 2, 1));
  EXPECT_TRUE(m.interior.empty());
  EXPECT_TRUE(check_volume(m).ok());
  EXPECT_TRUE(check_two_sided(m.boundaries[3].triangles, m.boundaries[4].triangles).ok());
}

TEST(NodeDoubling, PutsTheUpperSideWhereTheNormalPoints) {
  TetMesh m = kuhn_grid(4, 4, 2);
  m.interior =
      without_corners(grid_faces(m, 2, [](const Point& x) { return at_height(x, 1) && in_square(x, 1, 3); }));
  const std::vector<Triangle> before = m.interior;
  const Result<DoublingSummary> done = double_nodes(m, "upper", "lower");
  ASSERT_TRUE(done.ok());
  EXPECT_EQ(m.boundaries[3].name, "upper");
  EXPECT_EQ(m.boundaries[4].name, "lower");
  // Tets with the copied node lie above the surface.
  const auto copy = static_cast<std::int32_t>(m.points.size()) - 1;
  for (const Tet& tet : m.tets) {
    if (std::find(tet.begin(), tet.end(), copy) == tet.end()) continue;
    for (const std::int32_t node : tet) EXPECT_GE(m.points[static_cast<std::size_t>(node)].z(), 1);
  }
  // Both sides list the surface's triangles in their order; the lower side, outward from the fluid below,
  // keeps the surface's normal.
  for (std::size_t i = 0; i < before.size(); ++i) {
    Triangle upper = m.boundaries[3].triangles[i];
    for (std::int32_t& node : upper) node = done->origin[static_cast<std::size_t>(node)];
    EXPECT_EQ(sorted(upper), sorted(before[i]));
    EXPECT_EQ(sorted(m.boundaries[4].triangles[i]), sorted(before[i]));
  }
}

TEST(NodeDoubling, MakesATorusOfAPatchWithAHole) {
  TetMesh m = kuhn_grid(7, 7, 2);
  m.interior = without_corners(grid_faces(
      m, 2, [](const Point& x) { return at_height(x, 1) && in_square(x, 1, 6) && !in_square(x, 3, 4); }));
  const Result<DoublingSummary> done = double_nodes(m, "upper", "lower");
  ASSERT_TRUE(done.ok()) << done.error().message;
  EXPECT_EQ(done->single_nodes, 18 + 4);
  EXPECT_EQ(done->doubled_nodes, 12);
  std::vector<Triangle> both = m.boundaries[3].triangles;
  both.insert(both.end(), m.boundaries[4].triangles.begin(), m.boundaries[4].triangles.end());
  EXPECT_EQ(euler_characteristic(both), 0);
  EXPECT_TRUE(check_two_sided(m.boundaries[3].triangles, m.boundaries[4].triangles).ok());
  EXPECT_TRUE(check_volume(m).ok());
}

TEST(NodeDoubling, FollowsAFold) {
  TetMesh m = kuhn_grid(6, 6, 6);
  m.interior = grid_faces(m, 2, [](const Point& x) { return at_height(x, 2) && in_square(x, 2, 4); });
  const std::vector<Triangle> wall = grid_faces(m, 0, [](const Point& x) {
    return std::abs(x.x() - 4) < 1e-9 && x.y() > 2 && x.y() < 4 && x.z() > 2 && x.z() < 4;
  });
  for (const Triangle& t : wall)
    m.interior.push_back({t[0], t[2], t[1]}); // continues the floor's orientation
  m.interior = without_corners(m.interior);
  const Result<DoublingSummary> done = double_nodes(m, "upper", "lower");
  ASSERT_TRUE(done.ok()) << done.error().message;
  EXPECT_EQ(done->doubled_nodes, 3); // one in the floor, one in the wall, one on the crease
  EXPECT_EQ(done->single_nodes, 10);
  EXPECT_TRUE(check_volume(m).ok());
  EXPECT_TRUE(check_two_sided(m.boundaries[3].triangles, m.boundaries[4].triangles).ok());
}

TEST(NodeDoubling, RefusesATriangleThatIsNoFace) {
  TetMesh m = kuhn_grid(4, 4, 2);
  m.interior = grid_faces(m, 2, [](const Point& x) { return at_height(x, 1) && in_square(x, 1, 3); });
  m.interior[0] = {0, 7, 13};
  const Result<DoublingSummary> done = double_nodes(m, "upper", "lower");
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().kind, ErrorKind::numerical);
}

TEST(NodeDoubling, RefusesATriangleWithAllNodesOnFreeEdges) {
  TetMesh m = kuhn_grid(4, 4, 2);
  m.interior = grid_faces(m, 2, [](const Point& x) { return at_height(x, 1) && in_square(x, 1, 3); });
  const Result<DoublingSummary> done = double_nodes(m, "upper", "lower");
  ASSERT_FALSE(done.ok());
  EXPECT_NE(done.error().message.find("2 triangles"), std::string::npos) << done.error().message;
}

TEST(NodeDoubling, RefusesASurfaceOnTheOuterBoundary) {
  TetMesh m = kuhn_grid(4, 4, 2);
  m.interior = grid_faces(m, 2, [](const Point& x) { return at_height(x, 0) && in_square(x, 1, 3); });
  EXPECT_FALSE(double_nodes(m, "upper", "lower").ok());
}

TEST(NodeDoubling, RefusesABranchingSurface) {
  TetMesh m = kuhn_grid(6, 6, 6);
  m.interior = grid_faces(m, 2, [](const Point& x) { return at_height(x, 3) && in_square(x, 1, 5); });
  const std::vector<Triangle> wall = grid_faces(m, 0, [](const Point& x) {
    return std::abs(x.x() - 3) < 1e-9 && x.y() > 1 && x.y() < 5 && x.z() > 3 && x.z() < 5;
  });
  m.interior.insert(m.interior.end(), wall.begin(), wall.end());
  const Result<DoublingSummary> done = double_nodes(m, "upper", "lower");
  ASSERT_FALSE(done.ok());
  EXPECT_NE(done.error().message.find("separates 3 regions"), std::string::npos) << done.error().message;
}

} // namespace
} // namespace drogue::meshing
