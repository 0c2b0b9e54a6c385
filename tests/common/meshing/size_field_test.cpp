// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/size_field.hpp"

#include <algorithm>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace drogue::meshing {
namespace {

std::vector<Point> random_points(int count, unsigned seed) {
  std::mt19937 engine(seed);
  const auto next = [&] { return static_cast<double>(engine()) / static_cast<double>(std::mt19937::max()); };
  std::vector<Point> points;
  for (int i = 0; i < count; ++i) {
    const double x = next(), y = next(), z = next();
    points.emplace_back(x, y, 0.1 * z);
  }
  return points;
}

TEST(PointTree, AgreesWithTryingEveryPoint) {
  const std::vector<Point> points = random_points(500, 1);
  const PointTree tree(points);
  for (const Point& x : random_points(300, 2)) {
    const Point query = 2 * x - Point(0.5, 0.5, 0.5);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Point& p : points) nearest = std::min(nearest, (p - query).norm());
    EXPECT_DOUBLE_EQ(tree.distance(query), nearest);
    EXPECT_DOUBLE_EQ(tree.distance(query, 0.3), std::min(nearest, 0.3));
    const double rough = tree.distance(10 * query, 100, 0.1);
    EXPECT_GE(rough, tree.distance(10 * query));
    EXPECT_LE(rough, 1.1 * tree.distance(10 * query) + 1e-12);
  }
}

TEST(PointTree, EmptyTreeIsFarAway) {
  EXPECT_EQ(PointTree({}).distance(Point::Zero(), 5), 5);
}

TEST(SizeField, GrowsFromTheSurfaceAndStaysSmallInTheWake) {
  const std::vector<Point> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  SizeRule rule{.surface_size = 1, .largest_size = 10, .growth = 0.5, .wake = {}};
  const SizeField plain(rule, points, {{0, 1, 2}});
  EXPECT_DOUBLE_EQ(plain({0, 0, 0}), 1);
  EXPECT_DOUBLE_EQ(plain({1.0 / 3, 1.0 / 3, 0}), 1); // centre of the triangle
  EXPECT_NEAR(plain({-4.3, 0, 0}), 1 + 0.5 * 4, 1e-12);
  EXPECT_DOUBLE_EQ(plain({100, 0, 0}), 10);
  rule.wake = Wake{.bottom = {0, 0, 0}, .radius = 2, .length = 50, .size = 3};
  const SizeField wake(rule, points, {{0, 1, 2}});
  EXPECT_DOUBLE_EQ(wake({0, 0, 0}), 1);
  EXPECT_DOUBLE_EQ(wake({1, 1, 40}), 3);
  EXPECT_NEAR(wake({4, 0, 40}), 3 + 0.5 * 2, 1e-12);
  EXPECT_NEAR(wake({0, 0, 54}), 3 + 0.5 * 4, 1e-12);
  EXPECT_DOUBLE_EQ(wake({0, 0, -100}), 10);
}

} // namespace
} // namespace drogue::meshing
