// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/membrane_checks.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace drogue::meshing {
namespace {

struct Membrane {
  std::vector<Point> points;
  std::vector<Triangle> triangles;
};

/// A strip of n squares along x, each of two triangles, shifted to z.
void add_strip(Membrane& m, int n, double z) {
  const auto first = static_cast<std::int32_t>(m.points.size());
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j < 2; ++j) m.points.emplace_back(i, j, z);
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t a = first + 2 * i;
    m.triangles.push_back({a, a + 2, a + 3});
    m.triangles.push_back({a, a + 3, a + 1});
  }
}

std::string complaint(const Membrane& m) {
  const auto checked = check_membrane(m.points, m.triangles);
  return checked ? "" : checked.error().message;
}

void expect_refused(const Membrane& m, const std::string& because) {
  const auto checked = check_membrane(m.points, m.triangles);
  ASSERT_FALSE(checked.ok());
  EXPECT_EQ(checked.error().kind, ErrorKind::numerical);
  EXPECT_NE(checked.error().message.find(because), std::string::npos) << checked.error().message;
}

TEST(CheckMembrane, AcceptsSheetsThatNearlyTouch) {
  Membrane m;
  add_strip(m, 4, 0);
  add_strip(m, 4, 1e-4);
  EXPECT_EQ(complaint(m), "");
}

TEST(CheckMembrane, NamesSheetsThatTouchOrCross) {
  Membrane m;
  add_strip(m, 4, 0);
  add_strip(m, 4, 0);
  expect_refused(m, "crosses or touches itself: its triangle 0 (nodes 0, 2, 3)");
  Membrane crossing;
  add_strip(crossing, 4, 0);
  crossing.points.insert(crossing.points.end(), {{2.5, 0.3, -1}, {2.5, 0.4, 1}, {2.6, 0.5, 1}});
  crossing.triangles.push_back({10, 11, 12});
  expect_refused(crossing, "its triangle 4 (nodes 4, 6, 7)");
  expect_refused(crossing, "triangle 8 (nodes 10, 11, 12) at (2.53333, 0.4, 0.333333)");
}

TEST(CheckMembrane, RefusesAFoldOntoItself) {
  Membrane m{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 0}}, {{0, 1, 2}, {1, 0, 3}}};
  expect_refused(m, "crosses or touches itself");
  m.points[3].z() = 0.1; // folded, but apart
  EXPECT_EQ(complaint(m), "");
  m.points[3] = {0.3, -0.3, 0}; // unfolded
  EXPECT_EQ(complaint(m), "");
}

TEST(CheckMembrane, RefusesTrianglesThatCrossThoughTheyShareANode) {
  Membrane m{{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0.5, 0.5, -1}, {0.6, 0.5, 1}}, {{0, 1, 2}, {0, 3, 4}}};
  expect_refused(m, "crosses or touches itself");
}

TEST(CheckMembrane, NamesBadEdgesAndTriangles) {
  Membrane m;
  add_strip(m, 2, 0);
  m.points.emplace_back(0.5, 0.5, 1);
  m.triangles.push_back({0, 6, 3});
  expect_refused(m,
                 "3 triangles of the membrane meet in the edge between the nodes 0 and 3 at (0.5, 0.5, 0)");
  m.triangles.pop_back();
  std::swap(m.triangles[0][0], m.triangles[0][1]);
  expect_refused(m, "face opposite ways");
  std::swap(m.triangles[0][0], m.triangles[0][1]);
  m.points[2] = {0.5, 0.5, 0}; // on the diagonal
  expect_refused(m, "triangle 0 (nodes 0, 2, 3)");
  m.points[2].x() = std::nan("");
  expect_refused(m, "has no area");
}

TEST(CheckFreeEdges, CountsLoopsAndNamesOne) {
  Membrane m;
  add_strip(m, 3, 0);
  EXPECT_TRUE(check_free_edges(m.points, m.triangles, 1));
  m.triangles.erase(m.triangles.begin() + 2, m.triangles.begin() + 4); // torn in two
  const auto checked = check_free_edges(m.points, m.triangles, 1);
  ASSERT_FALSE(checked.ok());
  EXPECT_NE(checked.error().message.find("form 2 loops instead of 1: one has the edge between the nodes"),
            std::string::npos)
      << checked.error().message;
}

TEST(SegmentTriangleDistance, IsTheSmallestOfAFineSample) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  const auto point = [&] { return Point(coordinate(random), coordinate(random), coordinate(random)); };
  for (int trial = 0; trial < 50; ++trial) {
    const std::array<Point, 2> s{point(), point()};
    const std::array<Point, 3> t{point(), point(), point()};
    double sampled = 10;
    constexpr int n = 60;
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j)
        for (int k = 0; k <= n; ++k) {
          const Point on_triangle = t[0] + (i * (t[1] - t[0]) + j * (t[2] - t[0])) / n;
          sampled = std::min(sampled, (s[0] + k * (s[1] - s[0]) / n - on_triangle).norm());
        }
    const double found = segment_triangle_distance(s, t);
    EXPECT_LE(found, sampled + 1e-12);
    EXPECT_GT(found, sampled - 0.06); // a step of the sample
  }
}

} // namespace
} // namespace drogue::meshing
