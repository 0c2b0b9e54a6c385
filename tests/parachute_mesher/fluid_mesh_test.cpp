// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/fluid_mesh.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "common/meshing/checks.hpp"
#include "common/meshing/quality.hpp"
#include "parachute_mesher/structure_mesh.hpp"
#include "tests/parachute_mesher/inflated_shape.hpp"

namespace drogue::parachute {
namespace {

using mesh::Mesh;
using meshing::Point;

const Canopy t10{.diameter = 35, .vent_ratio = 0.1, .skirt_ratio = 0.1, .gores = 30};
constexpr Subdivision triangles{
    .main_rows = 12, .skirt_rows = 3, .across_vent = 1, .across_seam = 4, .across_skirt = 3};

Mesh structure() {
  const Rigging rigging{
      .line_length = 29.4, .line_elements = 2, .vent_elements = 1, .confluence_distance = 2.3};
  const Subdivision quadratic{
      .main_rows = 11, .skirt_rows = 2, .across_vent = 2, .across_seam = 2, .across_skirt = 2};
  return structure_mesh(
      t10, rigging, {.file = {}, .element = mesh::ElementKind::quad9, .rows = cloth_rows(t10, quadratic)});
}

FluidSettings settings() {
  return {.file = {},
          .structure_mesh = {},
          .structure_state = {},
          .rows = cloth_rows(t10, triangles),
          .half_width = 105,
          .upstream = 105,
          .downstream = 175,
          .canopy_size = 1.1,
          .largest_size = 32,
          .growth = 0.25,
          .wake_size = 2.6,
          .wake_length = 56};
}

CanopySurface surface() {
  const Mesh s = structure();
  Result<CanopySurface> result =
      inflated_canopy(t10, cloth_rows(t10, triangles), s, inflated_displacement(t10, s));
  EXPECT_TRUE(result.ok()) << result.error().message;
  return std::move(*result);
}

/// Made once for all tests.
const Result<FluidMeshResult>& inflated_mesh() {
  static const Result<FluidMeshResult> made = fluid_mesh(t10, settings(), surface());
  return made;
}

TEST(FluidMesh, MeshesTheInflatedCanopy) {
  const CanopySurface canopy = surface();
  const Result<FluidMeshResult>& made = inflated_mesh();
  ASSERT_TRUE(made.ok()) << made.error().message;
  const meshing::MembraneVolume& volume = made->volume;
  // Free edges: 30 edges at the vent, 30 * 3 at the skirt.
  EXPECT_EQ(volume.doubling.single_nodes, 120);
  EXPECT_EQ(volume.doubling.doubled_nodes + 120, static_cast<std::int32_t>(canopy.points.size()));
  const auto quality = meshing::summarise_quality(volume.mesh.points, volume.mesh.tets);
  EXPECT_GT(quality.smallest_angle, 5);
  EXPECT_NEAR(quality.total_volume, 210.0 * 210 * 280, 1e-6 * 210.0 * 210 * 280);

  // The canopy is a torus: both sides closed, one hole.
  const meshing::TetMesh tets = meshing::from_mesh(made->mesh);
  EXPECT_TRUE(meshing::check_volume(tets).ok());
  ASSERT_EQ(tets.boundaries.size(), 5U);
  std::vector<meshing::Triangle> both = tets.boundaries[3].triangles;
  both.insert(both.end(), tets.boundaries[4].triangles.begin(), tets.boundaries[4].triangles.end());
  EXPECT_EQ(meshing::euler_characteristic(both), 0);
  EXPECT_EQ(both.size(), 2 * canopy.triangles.size());

  // Both sides know where on the cloth they are, and nothing else does.
  const std::vector<double>& material = made->mesh.node_fields.at("material").values;
  std::size_t known = 0;
  for (std::size_t i = 0; i < material.size(); i += 3) known += std::isfinite(material[i]);
  EXPECT_EQ(known, canopy.points.size() + static_cast<std::size_t>(volume.doubling.doubled_nodes));
  for (const char* side : {"canopy_upper", "canopy_lower"})
    for (const std::int32_t node : made->mesh.nodes_of(side)) {
      const std::size_t i = 3 * static_cast<std::size_t>(node);
      const double s = std::hypot(material[i], material[i + 1]);
      EXPECT_TRUE(s > 1.75 - 1e-9 && s < 21 + 1e-9);
    }
}

/// Sum of the area vectors of a side, up and outward positive.
double outward_area(const Mesh& m, const char* side) {
  const mesh::ElementBlock& block = *m.blocks_of(side).front();
  const auto at = [&](std::int32_t node) { return Point::Map(m.points.data() + 3 * node); };
  double sum = 0;
  for (std::int32_t e = 0; e < block.count(); ++e) {
    const auto n = block.element(e);
    const Point area = 0.5 * (at(n[1]) - at(n[0])).cross(at(n[2]) - at(n[0]));
    sum += area.z();
  }
  return sum;
}

TEST(FluidMesh, SidesFaceEachOther) {
  const Result<FluidMeshResult>& made = inflated_mesh();
  ASSERT_TRUE(made.ok()) << made.error().message;
  // Normals leave the fluid: from above down into the canopy, from below up. Projected area: mouth without
  // vent.
  const double upper = outward_area(made->mesh, "canopy_upper"),
               lower = outward_area(made->mesh, "canopy_lower");
  EXPECT_LT(upper, -100);
  EXPECT_NEAR(upper, -lower, 1e-9 * lower);
}

TEST(FluidMesh, PutsCanopyNodesOnTheStructure) {
  const Mesh s = structure();
  const std::vector<double> zero(s.points.size(), 0);
  const Result<CanopySurface> flat = inflated_canopy(t10, cloth_rows(t10, triangles), s, zero);
  ASSERT_TRUE(flat.ok());
  for (std::size_t i = 0; i < flat->points.size(); ++i) {
    const double cloth = std::hypot(flat->material[i][0], flat->material[i][1]);
    EXPECT_NEAR(std::hypot(flat->points[i].x(), flat->points[i].y()), t10.radius(cloth), 2e-3);
    EXPECT_EQ(flat->points[i].z(), 0);
  }
}

TEST(FluidMesh, RefusesAStructureOfAnotherCanopy) {
  const Mesh s = structure();
  Canopy larger = t10;
  larger.diameter = 40;
  const std::vector<double> zero(s.points.size(), 0);
  const Result<CanopySurface> made = inflated_canopy(larger, cloth_rows(larger, triangles), s, zero);
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().kind, ErrorKind::config);
}

TEST(FluidMesh, RefusesACanopyThatTouchesItself) {
  // The flat pattern: the skirt lies on the disk.
  const Mesh s = structure();
  const std::vector<double> zero(s.points.size(), 0);
  const Result<CanopySurface> flat = inflated_canopy(t10, cloth_rows(t10, triangles), s, zero);
  ASSERT_TRUE(flat.ok());
  const Result<FluidMeshResult> made = fluid_mesh(t10, settings(), *flat);
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().kind, ErrorKind::numerical);
}

} // namespace
} // namespace drogue::parachute
