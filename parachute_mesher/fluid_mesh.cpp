// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/fluid_mesh.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "common/meshing/membrane_checks.hpp"
#include "parachute_mesher/material_map.hpp"

namespace drogue::parachute {
namespace {

/// Mean height of the nodes on the skirt edge.
double skirt_height(const CanopySurface& surface) {
  double sum = 0;
  for (const std::int32_t node : surface.rim) sum += surface.points[static_cast<std::size_t>(node)].z();
  return sum / static_cast<double>(surface.rim.size());
}

mesh::NodeField material_field(const CanopySurface& surface, const std::vector<std::int32_t>& origin) {
  mesh::NodeField field{3, {}};
  for (const std::int32_t node : origin) {
    const auto i = static_cast<std::size_t>(node);
    if (i < surface.material.size())
      field.values.insert(field.values.end(), surface.material[i].begin(), surface.material[i].end());
    else
      field.values.insert(field.values.end(), 3, std::numeric_limits<double>::quiet_NaN());
  }
  return field;
}

} // namespace

Result<CanopySurface> inflated_canopy(const Canopy& canopy, const ClothRows& rows,
                                      const mesh::Mesh& structure, const std::vector<double>& displacement) {
  const Result<MaterialMap> map = MaterialMap::create(structure, "canopy");
  if (!map) return map.error();
  std::vector<double> current = structure.points;
  for (std::size_t i = 0; i < current.size(); ++i) current[i] += displacement[i];

  const Cloth cloth = triangulate_cloth(canopy, rows);
  CanopySurface surface;
  surface.rim = cloth.rim;
  for (const ClothNode& node : cloth.nodes) {
    const std::array<double, 3> material = material_position(node);
    const auto x = map->interpolate(current, material[0], material[1]);
    if (!x)
      return config_error(
          "the structure mesh has no cloth at s = {:.6g}, theta = {:.6g}: it was made for another "
          "canopy",
          node.s, node.theta);
    surface.points.emplace_back((*x)[0], (*x)[1], (*x)[2]);
    surface.material.push_back(material);
  }
  for (std::size_t i = 0; i < cloth.elements.size(); i += 3)
    surface.triangles.push_back({cloth.elements[i], cloth.elements[i + 1], cloth.elements[i + 2]});
  return surface;
}

Result<FluidMeshResult> fluid_mesh(const Canopy& canopy, const FluidSettings& settings,
                                   const CanopySurface& surface) {
  const std::size_t free_edges = canopy.shape == Shape::cross ? 1 : 2 * (canopy.gaps.size() + 1);
  DROGUE_TRY(meshing::check_free_edges(surface.points, surface.triangles, free_edges));
  const double z = skirt_height(surface);
  const meshing::Box box{.low = {-settings.half_width, -settings.half_width, z - settings.upstream},
                         .high = {settings.half_width, settings.half_width, z + settings.downstream}};
  meshing::SizeRule sizes{.surface_size = settings.canopy_size,
                          .largest_size = settings.largest_size,
                          .growth = settings.growth,
                          .wake = {}};
  if (settings.wake_length > 0)
    sizes.wake = meshing::Wake{.bottom = {0, 0, z},
                               .radius = 0.5 * canopy.diameter,
                               .length = settings.wake_length,
                               .size = settings.wake_size};
  Result<meshing::MembraneVolume> volume = meshing::mesh_membrane_volume(
      box, surface.points, surface.triangles, sizes, "canopy_upper", "canopy_lower");
  if (!volume) return volume.error();
  FluidMeshResult result;
  result.mesh = meshing::to_mesh(volume->mesh, "fluid");
  result.mesh.node_fields.emplace("material", material_field(surface, volume->doubling.origin));
  result.volume = std::move(*volume);
  return result;
}

} // namespace drogue::parachute
