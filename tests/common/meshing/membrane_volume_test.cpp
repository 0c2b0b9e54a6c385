// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/membrane_volume.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "common/meshing/checks.hpp"
#include "common/meshing/quality.hpp"

namespace drogue::meshing {
namespace {

struct Membrane {
  std::vector<Point> points;
  std::vector<Triangle> triangles;
};

/// A disk of radius 1 in n rings of 4 n triangles' edges, bent to a parabolic cup opening downward.
Membrane cup(int n) {
  Membrane m;
  const int around = 4 * n;
  for (int i = 1; i <= n; ++i)
    for (int j = 0; j < around; ++j) {
      const double r = static_cast<double>(i) / n, theta = 2 * std::numbers::pi * j / around;
      m.points.emplace_back(r * std::cos(theta), r * std::sin(theta), 0.5 - 0.5 * r * r);
    }
  m.points.emplace_back(0, 0, 0.5);
  const auto node = [&](int i, int j) { return i == 0 ? n * around : (i - 1) * around + j % around; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < around; ++j) {
      m.triangles.push_back({node(i, j), node(i + 1, j), node(i + 1, j + 1)});
      if (i > 0) m.triangles.push_back({node(i, j), node(i + 1, j + 1), node(i, j + 1)});
    }
  return m;
}

const Box box{.low = {-4, -4, -4}, .high = {4, 4, 6}};
const SizeRule sizes{.surface_size = 0.3, .largest_size = 2, .growth = 0.4, .wake = {}};

Result<MembraneVolume> mesh(const Membrane& m) {
  return mesh_membrane_volume(box, m.points, m.triangles, sizes, "upper", "lower");
}

TEST(MembraneVolume, MeshesABoxAroundACup) {
  const Membrane m = cup(5);
  const Result<MembraneVolume> made = mesh(m);
  ASSERT_TRUE(made.ok()) << made.error().message;
  EXPECT_EQ(made->doubling.single_nodes, 20);
  EXPECT_EQ(made->doubling.doubled_nodes, 81);
  EXPECT_TRUE(std::equal(m.points.begin(), m.points.end(), made->mesh.points.begin()));
  const QualitySummary q = summarise_quality(made->mesh.points, made->mesh.tets);
  EXPECT_NEAR(q.total_volume, 8.0 * 8 * 10, 1e-9);
  EXPECT_GT(q.smallest_angle, 5);
  // Elements are about as large as asked for.
  EXPECT_GT(made->mesh.points.size(), 400U);
  EXPECT_LT(made->mesh.points.size(), 2000U);
  ASSERT_EQ(made->mesh.boundaries.size(), 5U);
  for (const Triangle& t : made->mesh.boundaries[0].triangles)
    for (const std::int32_t node : t) EXPECT_EQ(made->mesh.points[static_cast<std::size_t>(node)].z(), -4);
  for (const Triangle& t : made->mesh.boundaries[1].triangles)
    for (const std::int32_t node : t) EXPECT_EQ(made->mesh.points[static_cast<std::size_t>(node)].z(), 6);
}

TEST(MembraneVolume, RefusesAMembraneOutsideTheBox) {
  Membrane m = cup(4);
  for (Point& x : m.points) x.x() += 3.5;
  const Result<MembraneVolume> made = mesh(m);
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().message, "the embedded surface is not inside the box");
}

TEST(MembraneVolume, RefusesAMembraneThatIntersectsItself) {
  Membrane m = cup(4);
  const Membrane other = cup(4);
  const auto offset = static_cast<std::int32_t>(m.points.size());
  for (const Point& x : other.points)
    m.points.emplace_back(x.x() + 0.1, x.z() - 0.3, x.y()); // stands across the first
  for (const Triangle& t : other.triangles)
    m.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  const Result<MembraneVolume> made = mesh(m);
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().kind, ErrorKind::numerical);
  EXPECT_NE(made.error().message.find("crosses or touches itself"), std::string::npos)
      << made.error().message;
}

} // namespace
} // namespace drogue::meshing
