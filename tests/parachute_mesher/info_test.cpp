// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/info.hpp"

#include <numbers>

#include <gtest/gtest.h>

#include "parachute_mesher/structure_mesh.hpp"

namespace drogue::parachute {
namespace {

bool contains(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

TEST(Info, MeasuresCurvedElements) {
  const Canopy t10{.diameter = 35, .vent_ratio = 0.1, .skirt_ratio = 0.1, .gores = 30};
  const Rigging rigging{
      .line_length = 29.4, .line_elements = 2, .vent_elements = 1, .confluence_distance = 0};
  const Subdivision rows{
      .main_rows = 11, .skirt_rows = 2, .across_vent = 2, .across_seam = 2, .across_skirt = 2};
  const mesh::Mesh m = structure_mesh(
      t10, rigging, {.file = {}, .element = mesh::ElementKind::quad9, .rows = cloth_rows(t10, rows)});
  // Quadratic arcs miss a circle by the fourth power of their angle.
  EXPECT_NEAR(measure(m, *m.blocks_of("canopy").front()), t10.cloth_area(), 1e-5 * t10.cloth_area());
  EXPECT_NEAR(measure(m, *m.blocks_of("suspension_lines").front()), 30 * 29.4, 1e-9);
  EXPECT_EQ(measure(m, *m.blocks_of("apex").front()), 0);
  const std::string text = describe(m);
  EXPECT_TRUE(contains(text, "canopy             780 x 9-node quadrilateral, area 1298.8")) << text;
  EXPECT_TRUE(contains(text, "node field \"material\", 3 components")) << text;
  EXPECT_FALSE(contains(text, "tetrahedra")) << text;
}

TEST(Info, NamesWhatIsWrongWithAVolume) {
  mesh::Mesh m;
  m.points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  m.blocks = {{"wall", mesh::ElementKind::tri3, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}},
              {"fluid", mesh::ElementKind::tet4, {0, 1, 2, 3}}};
  EXPECT_TRUE(contains(describe(m), "conforming, every boundary face named")) << describe(m);
  EXPECT_TRUE(contains(describe(m), "volume 0.166667")) << describe(m);
  m.blocks[0].nodes.resize(9);
  EXPECT_TRUE(contains(describe(m), "not conforming: 1 faces")) << describe(m);
}

} // namespace
} // namespace drogue::parachute
