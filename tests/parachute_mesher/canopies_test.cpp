// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/parachute_mesher/canopies.hpp"

#include <cmath>
#include <map>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "parachute_mesher/info.hpp"
#include "structure_solver/case.hpp"

namespace drogue::parachute {
namespace {

using mesh::ElementBlock;
using mesh::ElementKind;
using mesh::Mesh;

bool is_quadratic(ElementKind kind) {
  return kind == ElementKind::tri6 || kind == ElementKind::quad9;
}
std::size_t corner_count(ElementKind kind) {
  return kind == ElementKind::tri3 || kind == ElementKind::tri6 ? 3 : 4;
}

std::string title(const Example& example, ElementKind kind) {
  return example.name + ", " + std::string(mesh::name(kind));
}

const ElementBlock& cloth(const Mesh& m) {
  return *m.blocks_of("canopy").front();
}

/// Edges between corners, and how many elements have each.
std::map<std::pair<std::int32_t, std::int32_t>, int> edges(const Mesh& m) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> count;
  const ElementBlock& block = cloth(m);
  const std::size_t n = corner_count(block.kind);
  for (std::int32_t e = 0; e < block.count(); ++e)
    for (std::size_t i = 0; i < n; ++i)
      ++count[std::minmax(block.element(e)[i], block.element(e)[(i + 1) % n])];
  return count;
}

template <class Test>
void for_all(Test test) {
  for (const Example& example : examples())
    for (const ElementKind kind : membrane_kinds) {
      SCOPED_TRACE(title(example, kind));
      test(example, make(example, kind));
    }
}

TEST(Canopies, ClothHasTheAreaOfItsClosedFormula) {
  for_all([](const Example& example, const Mesh& m) {
    EXPECT_NEAR(example.canopy.cloth_area(), example.area, 1e-9 * example.area);
    const double area = measure(m, cloth(m));
    if (example.rings == 0) {
      EXPECT_NEAR(area, example.area, 1e-10 * example.area); // straight edges
      return;
    }
    // Straight sides miss a circle by (angle)^2 / 6 and in a sphere's meridian as well, quadratic ones by the
    // fourth power.
    const double angle = 2 * std::numbers::pi / (2 * example.canopy.gores);
    EXPECT_NEAR(area, example.area,
                (is_quadratic(cloth(m).kind) ? 2e-4 : 2 * angle * angle / 6) * example.area);
    EXPECT_NE(area, example.area);
  });
}

TEST(Canopies, TopologyIsThatOfRingsOrOfADisk) {
  for_all([](const Example& example, const Mesh& m) {
    const ElementBlock& block = cloth(m);
    const std::size_t n = corner_count(block.kind);
    std::set<std::int32_t> corners, all(block.nodes.begin(), block.nodes.end());
    for (std::int32_t e = 0; e < block.count(); ++e)
      corners.insert(block.element(e).begin(), block.element(e).begin() + static_cast<std::ptrdiff_t>(n));
    const auto lines = edges(m);
    const int euler = static_cast<int>(corners.size()) - static_cast<int>(lines.size()) + block.count();
    EXPECT_EQ(euler, example.rings == 0 ? 1 : 0); // a ring has 0, whatever their number
    int free_edges = 0;
    for (const auto& [edge, count] : lines) {
      EXPECT_LE(count, 2);
      free_edges += count == 1;
    }
    // Two edges across a gore at both ends of every ring; on a cross the ends and sides of four arms.
    EXPECT_EQ(free_edges, example.rings == 0 ? 4 * (6 + 2 * 5) : example.rings * 2 * 16 * 2);
    if (is_quadratic(block.kind)) {
      EXPECT_EQ(all.size(),
                corners.size() + lines.size() + (n == 4 ? static_cast<std::size_t>(block.count()) : 0));
    }
  });
}

TEST(Canopies, ElementsFaceOutward) {
  for_all([](const Example& example, const Mesh& m) {
    const ElementBlock& block = cloth(m);
    const std::size_t n = corner_count(block.kind);
    const std::vector<double>& material = m.node_fields.at("material").values;
    for (std::int32_t e = 0; e < block.count(); ++e) {
      double twice = 0; // signed area in the unfolded pattern
      for (std::size_t i = 0; i < n; ++i) {
        const double* a = &material[3 * static_cast<std::size_t>(block.element(e)[i])];
        const double* b = &material[3 * static_cast<std::size_t>(block.element(e)[(i + 1) % n])];
        twice += a[0] * b[1] - a[1] * b[0];
      }
      EXPECT_GT(twice, 0) << example.name << " element " << e;
    }
  });
}

TEST(Canopies, LinesRunFromTheClothToTheConfluencePoints) {
  for_all([](const Example& example, const Mesh& m) {
    constexpr std::size_t lines = 16; // of 16 gores, or of 4 arms with 4 each
    EXPECT_EQ(m.nodes_of("skirt_edge").size(), lines);
    EXPECT_EQ(m.blocks_of("suspension_lines").front()->count(), 3 * 16);
    EXPECT_EQ(m.has_group("vent_lines"), example.rings > 0 && example.rigging.vent_elements > 0);
    EXPECT_EQ(m.has_group("inner_lines"), example.rigging.inner_line_elements > 0);
    std::map<std::int32_t, int> ends;
    const ElementBlock& suspension = *m.blocks_of("suspension_lines").front();
    for (std::int32_t e = 2; e < suspension.count(); e += 3) ++ends[suspension.element(e)[1]];
    const auto confluence = m.nodes_of("confluence");
    ASSERT_EQ(confluence.size(), 2U);
    EXPECT_EQ(ends[confluence[0]], 8);
    EXPECT_EQ(ends[confluence[1]], 8);
    // Radials run along the cloth and across the gaps.
    const double along =
        example.rings == 0 ? 8 * 10 : 16 * (example.canopy.s_skirt() - example.canopy.s_vent());
    EXPECT_NEAR(measure(m, *m.blocks_of("radials").front()), along,
                example.canopy.shape == Shape::hemispherical ? 0.01 * along : 1e-9);
  });
}

TEST(Canopies, StructureSolverTakesEveryOneWithRisersAndPayload) {
  for (Example example : examples())
    for (const ElementKind kind : membrane_kinds) {
      SCOPED_TRACE(title(example, kind));
      example.rigging.risers = {
          .length = 1, .elements = 2, .confluence_depth = 0.5, .payload_width = 0.4, .payload_height = 0.3};
      const Mesh m = make(example, kind);
      structure::Settings s;
      const structure::LineMaterial line{1e-5, 1000, 1e9, 0, structure::StrainMeasure::green, true};
      s.membranes = {{"canopy", {1e-4, 600, 1e8, 0.3, 0}}};
      for (const char* group : {"suspension_lines", "radials", "vent_lines", "inner_lines", "risers"})
        if (m.has_group(group)) s.cables.push_back({group, line, {}});
      structure::LineMaterial truss = line;
      truss.tension_only = false;
      s.trusses = {{"payload_trusses", truss, {}}};
      s.masses = {{"payload", 20}};
      s.gravity[2] = std::move(*config::Expression::parse("-9.81"));
      s.pressures = {{"canopy", std::move(*config::Expression::parse("20"))}};
      config::Report report;
      const auto model = structure::build_model(s, m, report);
      ASSERT_TRUE(model.has_value()) << report.lines().front();
      EXPECT_EQ(report.lines().size(), 0U);
      double mass = 0, expected = 4 * 20 + 600 * 1e-4 * measure(m, cloth(m));
      for (const double nodal : model->mass) mass += nodal;
      for (const ElementBlock& block : m.blocks)
        if (mesh::dimension(block.kind) == 1) expected += 1000 * 1e-5 * measure(m, block);
      EXPECT_NEAR(mass, expected, 1e-5 * expected);
    }
}

TEST(Canopies, AskForEnoughRowsForTheirRings) {
  Canopy canopy = examples()[5].canopy;
  ASSERT_EQ(canopy.gaps.size(), 3U);
  const ClothRows rows = cloth_rows(canopy, {.main_rows = 4, .across_vent = 2, .across_seam = 2});
  ASSERT_EQ(rows.s.size(), 8U); // a row of elements each
  EXPECT_EQ(rows.is_open, (std::vector<bool>{false, true, false, true, false, true, false, false}));
  EXPECT_NEAR(rows.s[1], 2, 1e-12);
  EXPECT_NEAR(rows.s[2], 2.2, 1e-12);
}

} // namespace
} // namespace drogue::parachute
