// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/material_map.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "parachute_mesher/structure_mesh.hpp"

namespace drogue::parachute {
namespace {

const Canopy t10{.diameter = 35, .vent_ratio = 0.1, .skirt_ratio = 0.1, .gores = 30};

mesh::Mesh structure(bool quadratic) {
  const Rigging rigging{
      .line_length = 29.4, .line_elements = 2, .vent_elements = 1, .confluence_distance = 2.3};
  const Subdivision rows{
      .main_rows = 11, .skirt_rows = 2, .across_vent = 2, .across_seam = 2, .across_skirt = 2};
  return structure_mesh(t10, rigging,
                        {.file = {},
                         .element = quadratic ? mesh::ElementKind::quad9 : mesh::ElementKind::tri3,
                         .rows = cloth_rows(t10, rows)});
}

TEST(MaterialMap, ReproducesLinearFieldsInsideTheCloth) {
  for (const bool quadratic : {true, false}) {
    const mesh::Mesh m = structure(quadratic);
    const Result<MaterialMap> map = MaterialMap::create(m, "canopy");
    ASSERT_TRUE(map.ok()) << map.error().message;
    const std::vector<double>& X = m.node_fields.at("material").values;
    std::vector<double> field(X.size());
    for (std::size_t i = 0; i < X.size(); i += 3) {
      field[i] = 1 + 2 * X[i] - 3 * X[i + 1];
      field[i + 1] = X[i];
      field[i + 2] = X[i + 1];
    }
    for (double s = 1.8; s < 20.9; s += 0.37)
      for (double theta = 0.01; theta < 6.28; theta += 0.53) {
        const double x = s * std::cos(theta), y = s * std::sin(theta);
        const auto value = map->interpolate(field, x, y);
        ASSERT_TRUE(value.has_value()) << s << " " << theta;
        EXPECT_NEAR((*value)[0], 1 + 2 * x - 3 * y, 1e-9);
        EXPECT_NEAR((*value)[1], x, 1e-9);
        EXPECT_NEAR((*value)[2], y, 1e-9);
      }
  }
}

TEST(MaterialMap, TellsTheSkirtFromTheDiskAboveIt) {
  const mesh::Mesh m = structure(true);
  const Result<MaterialMap> map = MaterialMap::create(m, "canopy");
  ASSERT_TRUE(map.ok());
  // Flat radius 15 is cloth coordinate 15 on the disk and 20 on the skirt; both lie on the flat mesh's ring.
  for (const double s : {15.0, 20.0}) {
    const auto flat = map->interpolate(m.points, s, 0);
    ASSERT_TRUE(flat.has_value());
    EXPECT_NEAR((*flat)[0], 15, 2e-3);
  }
}

TEST(MaterialMap, TakesTheNearestPointAtAnEdgeAndNothingFarAway) {
  const mesh::Mesh m = structure(false);
  const Result<MaterialMap> map = MaterialMap::create(m, "canopy");
  ASSERT_TRUE(map.ok());
  const std::vector<double>& X = m.node_fields.at("material").values;
  // In the middle of a chord the cloth's edge lies 21 (1 - cos 3 degrees) = 0.029 inside the circle.
  const auto edge = map->interpolate(X, 21 * std::cos(M_PI / 60), 21 * std::sin(M_PI / 60));
  ASSERT_TRUE(edge.has_value());
  EXPECT_NEAR(std::hypot((*edge)[0], (*edge)[1]), 21 * std::cos(M_PI / 60), 1e-4);
  EXPECT_FALSE(map->interpolate(X, 22, 0).has_value());
  EXPECT_FALSE(map->interpolate(X, 0, 0).has_value());
}

TEST(MaterialMap, RefusesMeshesWithoutMaterialCoordinates) {
  mesh::Mesh m = structure(true);
  EXPECT_FALSE(MaterialMap::create(m, "canopi").ok());
  EXPECT_FALSE(MaterialMap::create(m, "radials").ok());
  m.node_fields.at("material").values[0] = std::nan("");
  EXPECT_FALSE(MaterialMap::create(m, "canopy").ok());
  m.node_fields.clear();
  const Result<MaterialMap> map = MaterialMap::create(m, "canopy");
  ASSERT_FALSE(map.ok());
  EXPECT_EQ(map.error().kind, ErrorKind::config);
}

} // namespace
} // namespace drogue::parachute
