// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/fluid_mesh.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "common/meshing/checks.hpp"
#include "common/meshing/quality.hpp"
#include "parachute_mesher/structure_mesh.hpp"
#include "tests/parachute_mesher/inflated_shape.hpp"

namespace drogue::parachute {
namespace {

using mesh::Mesh;
using meshing::Point;

constexpr Canopy t10{.diameter = 35, .vent_ratio = 0.1, .skirt_ratio = 0.1, .gores = 30};
constexpr Subdivision triangles{
    .main_rows = 12, .skirt_rows = 3, .across_vent = 1, .across_seam = 4, .across_skirt = 3};

Mesh structure() {
  const Rigging rigging{
      .line_length = 29.4, .line_elements = 2, .vent_elements = 1, .confluence_distance = 2.3};
  const Subdivision quadratic{
      .main_rows = 11, .skirt_rows = 2, .across_vent = 2, .across_seam = 2, .across_skirt = 2};
  return structure_mesh(t10, rigging, {.file = {}, .quadratic = true, .rows = cloth_rows(t10, quadratic)});
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

TEST(FluidMesh, MeshesTheInflatedCanopy) {
  const CanopySurface canopy = surface();
  const Result<FluidMeshResult> made = fluid_mesh(t10, settings(), canopy);
  ASSERT_TRUE(made.ok()) << made.error().message;
  const meshing::MembraneVolume& volume = made->volume;
  // Free edges: 30 edges at the vent, 30 * 3 at the skirt.
  EXPECT_EQ(volume.doubling.single_nodes, 120);
  EXPECT_EQ(volume.doubling.doubled_nodes + 120, static_cast<std::int32_t>(canopy.points.size()));
  const auto quality = meshing::summarise_quality(volume.mesh.points, volume.mesh.tets);
  EXPECT_GT(quality.smallest_angle, 5);
  EXPECT_NEAR(quality.total_volume, 210.0 * 210 * 280, 1e-6 * 210.0 * 210 * 280);
}

} // namespace
} // namespace drogue::parachute
