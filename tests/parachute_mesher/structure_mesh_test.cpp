// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/structure_mesh.hpp"

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

namespace drogue::parachute {
namespace {

using mesh::ElementBlock;
using mesh::Mesh;

// The T-10 of [stein2001], in feet.
const Canopy t10{.diameter = 35, .vent_ratio = 0.1, .skirt_ratio = 0.1, .gores = 30};
const Rigging rigging{
    .line_length = 29.4, .line_elements = 10, .vent_elements = 3, .confluence_distance = 2.3};
constexpr Subdivision compatible{.main_rows = 42,
                                 .skirt_rows = 9,
                                 .across_vent = 1,
                                 .across_seam = 8,
                                 .across_skirt = 6,
                                 .across_exponent = 0.584};
constexpr Subdivision incompatible{
    .main_rows = 11, .skirt_rows = 2, .across_vent = 2, .across_seam = 2, .across_skirt = 2};

Mesh make(const Subdivision& subdivision, bool quadratic) {
  return structure_mesh(t10, rigging,
                        {.file = {},
                         .element = quadratic ? mesh::ElementKind::quad9 : mesh::ElementKind::tri3,
                         .rows = cloth_rows(t10, subdivision)});
}

std::int32_t count(const Mesh& m, const char* group) {
  return m.blocks_of(group).front()->count();
}

std::array<double, 3> at(const std::vector<double>& values, std::int32_t node) {
  const std::size_t i = 3 * static_cast<std::size_t>(node);
  return {values[i], values[i + 1], values[i + 2]};
}

double distance(const Mesh& m, std::int32_t a, std::int32_t b) {
  const auto p = at(m.points, a), q = at(m.points, b);
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

double length(const Mesh& m, const char* group) {
  double sum = 0;
  const ElementBlock& block = *m.blocks_of(group).front();
  for (std::int32_t e = 0; e < block.count(); ++e)
    sum += distance(m, block.element(e)[0], block.element(e)[1]);
  return sum;
}

/// Signed area, in the x-y plane, of the polygon of an element's corners.
double signed_area(const std::vector<double>& x, std::span<const std::int32_t> nodes) {
  const std::size_t corners = nodes.size() == 9 ? 4 : 3;
  double twice = 0;
  for (std::size_t i = 0; i < corners; ++i) {
    const auto a = at(x, nodes[i]), b = at(x, nodes[(i + 1) % corners]);
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return 0.5 * twice;
}

double cloth_area(const Mesh& m) {
  double sum = 0;
  const ElementBlock& block = *m.blocks_of("canopy").front();
  for (std::int32_t e = 0; e < block.count(); ++e) sum += std::abs(signed_area(m.points, block.element(e)));
  return sum;
}

TEST(StructureMesh, HasThePapersIncompatibleCounts) {
  const Mesh m = make(incompatible, true);
  EXPECT_EQ(m.node_count(), 3573);
  EXPECT_EQ(count(m, "canopy"), 780);
  EXPECT_EQ(m.blocks_of("canopy").front()->kind, mesh::ElementKind::quad9);
  EXPECT_EQ(count(m, "radials"), 780);
  EXPECT_EQ(count(m, "vent_lines"), 90);
  EXPECT_EQ(count(m, "suspension_lines"), 300);
  EXPECT_EQ(count(m, "confluence"), 2);
  EXPECT_EQ(count(m, "apex"), 1);
  EXPECT_EQ(count(m, "skirt_edge"), 30);
}

TEST(StructureMesh, HasThePapersCompatibleCounts) {
  const Mesh m = make(compatible, false);
  EXPECT_EQ(m.node_count(), 9183);
  EXPECT_EQ(count(m, "canopy"), 17490);
  EXPECT_EQ(m.blocks_of("canopy").front()->kind, mesh::ElementKind::tri3);
  EXPECT_EQ(count(m, "radials") + count(m, "vent_lines") + count(m, "suspension_lines"), 1920);
}

TEST(StructureMesh, ClothHasTheConstructedArea) {
  EXPECT_NEAR(t10.cloth_area(), 1298.9, 0.1); // [stein2001]: disk - vent + skirt ring, square feet
  // A regular polygon of n corners has the area of its circle times sin(2 pi / n) / (2 pi / n).
  const double angle = 2 * std::numbers::pi / 60;
  EXPECT_NEAR(cloth_area(make(incompatible, true)), t10.cloth_area() * std::sin(angle) / angle, 1e-9);
  EXPECT_NEAR(cloth_area(make(compatible, false)), t10.cloth_area(), 2e-3 * t10.cloth_area());
}

TEST(StructureMesh, LinesHaveTheirLengths) {
  for (const bool quadratic : {true, false}) {
    const Mesh m = make(quadratic ? incompatible : compatible, quadratic);
    EXPECT_NEAR(length(m, "radials"), 30 * (21 - 1.75), 1e-9);
    EXPECT_NEAR(length(m, "vent_lines"), 30 * 1.75, 1e-9);
  }
  Rigging single = rigging;
  single.confluence_distance = 0;
  const Mesh m = structure_mesh(
      t10, single, {.file = {}, .element = mesh::ElementKind::quad9, .rows = cloth_rows(t10, incompatible)});
  EXPECT_EQ(count(m, "confluence"), 1);
  EXPECT_NEAR(length(m, "suspension_lines"), 30 * 29.4, 1e-9);
}

TEST(StructureMesh, LinesOfEachSideMeetInTheirConfluencePoint) {
  const Mesh m = make(incompatible, true);
  const auto& points = m.blocks_of("confluence").front()->nodes;
  const auto first = at(m.points, points[0]), second = at(m.points, points[1]);
  EXPECT_NEAR(first[1] - second[1], 2.3, 1e-12);
  EXPECT_NEAR(std::hypot(first[2], 14), 29.4, 1e-12);
  EXPECT_LT(first[2], 0);
  std::map<std::int32_t, int> lines;
  const ElementBlock& block = *m.blocks_of("suspension_lines").front();
  for (std::int32_t e = 9; e < block.count(); e += 10) {
    const std::int32_t end = block.element(e)[1];
    ++lines[end];
    EXPECT_GT(at(m.points, block.element(e - 9)[0])[1] * at(m.points, end)[1], 0) << "line " << e / 10;
  }
  EXPECT_EQ(lines, (std::map<std::int32_t, int>{{points[0], 15}, {points[1], 15}}));
}

TEST(StructureMesh, MaterialMapIsInjectiveAndElementsPointOutward) {
  for (const bool quadratic : {true, false}) {
    const Mesh m = make(quadratic ? incompatible : compatible, quadratic);
    const std::vector<double>& material = m.node_fields.at("material").values;
    ASSERT_EQ(material.size(), m.points.size());
    // Positive orientation in the unfolded pattern and the right total area: elements do not overlap there.
    const ElementBlock& block = *m.blocks_of("canopy").front();
    double area = 0;
    for (std::int32_t e = 0; e < block.count(); ++e) {
      const double a = signed_area(material, block.element(e));
      EXPECT_GT(a, 0);
      area += a;
      // In the flat pattern the skirt lies upside down.
      double s = 0;
      for (const std::int32_t node : block.element(e)) {
        const auto x = at(material, node);
        s = std::max(s, std::hypot(x[0], x[1]));
      }
      EXPECT_GT(signed_area(m.points, block.element(e)) * (s < 17.5 + 1e-9 ? 1 : -1), 0);
    }
    EXPECT_NEAR(area, std::numbers::pi * (21 * 21 - 1.75 * 1.75), 3e-3 * area);
    std::set<std::array<double, 3>> seen;
    for (const std::int32_t node : m.nodes_of("canopy"))
      EXPECT_TRUE(seen.insert(at(material, node)).second) << node;
    for (const char* group : {"confluence", "apex"})
      for (const std::int32_t node : m.nodes_of(group)) EXPECT_TRUE(std::isnan(at(material, node)[0]));
  }
}

TEST(StructureMesh, EveryNodeIsUsed) {
  const Mesh m = make(incompatible, true);
  std::set<std::int32_t> used;
  for (const ElementBlock& block : m.blocks) used.insert(block.nodes.begin(), block.nodes.end());
  EXPECT_EQ(static_cast<std::int32_t>(used.size()), m.node_count());
}

} // namespace
} // namespace drogue::parachute
