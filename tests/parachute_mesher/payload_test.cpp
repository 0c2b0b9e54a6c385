// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cmath>
#include <map>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "parachute_mesher/structure_mesh.hpp"

namespace drogue::parachute {
namespace {

using mesh::ElementBlock;
using mesh::Mesh;

/// The free-fall case of configs/t10.
Mesh free_fall() {
  const Canopy t10{.diameter = 35, .vent_ratio = 0.1, .skirt_ratio = 0.1, .gores = 30};
  const Rigging rigging{
      .line_length = 29.4,
      .line_elements = 10,
      .vent_elements = 3,
      .confluence_distance = 2.3,
      .inner_line_elements = 0,
      .risers = Risers{
          .length = 3, .elements = 5, .confluence_depth = 2.3, .payload_width = 1.5, .payload_height = 1}};
  return structure_mesh(
      t10, rigging,
      {.file = {},
       .element = mesh::ElementKind::quad9,
       .rows = cloth_rows(
           t10, {.main_rows = 11, .skirt_rows = 2, .across_vent = 2, .across_seam = 2, .across_skirt = 2})});
}

Eigen::Vector3d at(const Mesh& m, std::int32_t node) {
  return Eigen::Vector3d::Map(&m.points[3 * static_cast<std::size_t>(node)]);
}

TEST(Payload, HasThePapersCounts) {
  const Mesh m = free_fall();
  EXPECT_EQ(m.node_count(), 3595);
  EXPECT_EQ(m.blocks_of("canopy").front()->count(), 780);
  EXPECT_EQ(m.blocks_of("risers").front()->count(), 20);
  EXPECT_EQ(m.blocks_of("payload_trusses").front()->count(), 6);
  EXPECT_EQ(m.nodes_of("payload").size(), 4U);
  EXPECT_EQ(m.nodes_of("confluence").size(), 4U);
}

TEST(Payload, FrontRisersHaveSevenLinesAndRearOnesEight) {
  const Mesh m = free_fall();
  std::map<std::int32_t, int> lines;
  const ElementBlock& block = *m.blocks_of("suspension_lines").front();
  for (std::int32_t e = 9; e < block.count(); e += 10) {
    const Eigen::Vector3d skirt = at(m, block.element(e - 9)[0]), end = at(m, block.element(e)[1]);
    ++lines[block.element(e)[1]];
    EXPECT_GT(skirt.y() * end.y(), 0);
    // The line at 90 degrees and the one opposite belong to the rear.
    EXPECT_GT((skirt.x() - 1e-6) * end.x(), 0);
  }
  ASSERT_EQ(lines.size(), 4U);
  for (const auto& [node, count] : lines) EXPECT_EQ(count, at(m, node).x() > 0 ? 7 : 8);
}

TEST(Payload, HangsOnFourRisersAndIsATetrahedron) {
  const Mesh m = free_fall();
  const std::vector<std::int32_t> corners = m.nodes_of("payload");
  const Eigen::Vector3d a = at(m, corners[0]);
  const double volume = (at(m, corners[1]) - a).cross(at(m, corners[2]) - a).dot(at(m, corners[3]) - a) / 6;
  EXPECT_NEAR(std::abs(volume), 1.5 * 1.5 * 1 / 3, 1e-12); // a third of its box
  std::map<std::int32_t, int> trusses;
  for (const std::int32_t node : m.blocks_of("payload_trusses").front()->nodes) ++trusses[node];
  for (const std::int32_t corner : corners) EXPECT_EQ(trusses[corner], 3);
  const ElementBlock& risers = *m.blocks_of("risers").front();
  std::set<std::int32_t> tops, bottoms;
  for (std::int32_t e = 0; e < 20; e += 5) {
    const std::int32_t top = risers.element(e)[0], bottom = risers.element(e + 4)[1];
    tops.insert(top);
    bottoms.insert(bottom);
    const double drop = at(m, top).z() - at(m, bottom).z();
    EXPECT_NEAR(std::abs(drop - 3), 0.5, 1e-12);
    EXPECT_GT(at(m, top).x() * at(m, bottom).x(), 0);
    EXPECT_GT(at(m, top).y() * at(m, bottom).y(), 0);
  }
  EXPECT_EQ(std::vector<std::int32_t>(tops.begin(), tops.end()), m.nodes_of("confluence"));
  EXPECT_EQ(std::vector<std::int32_t>(bottoms.begin(), bottoms.end()), corners);
}

} // namespace
} // namespace drogue::parachute
