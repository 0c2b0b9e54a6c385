// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/mesh/mesh.hpp"
#include "common/meshing/membrane_volume.hpp"
#include "parachute_mesher/settings.hpp"

namespace drogue::parachute {

/// The canopy of the fluid mesh: its own triangulation of the cloth, in the inflated state.
struct CanopySurface {
  std::vector<meshing::Point> points;
  std::vector<meshing::Triangle> triangles; ///< normals outward
  std::vector<std::array<double, 3>> material;
  std::vector<std::int32_t> rim; ///< nodes on the skirt edge
};

/// Triangulates the cloth and puts every node where the structure's element at its material coordinates has
/// moved. `displacement` has shape {structure node count, 3} [length]. Errors (ErrorKind::config): the
/// structure mesh does not cover the cloth of this canopy.
[[nodiscard]] Result<CanopySurface> inflated_canopy(const Canopy& canopy, const ClothRows& rows,
                                                    const mesh::Mesh& structure,
                                                    const std::vector<double>& displacement);

struct FluidMeshResult {
  mesh::Mesh mesh;
  meshing::MembraneVolume volume;
};

/// The box around the canopy, the flow in +z: boundaries "inflow", "outflow", "side", "canopy_upper",
/// "canopy_lower", volume "fluid", node field "material" on both sides of the canopy.
/// Errors (ErrorKind::numerical): the canopy is torn or crosses itself; the volume cannot be meshed or the
/// mesh fails a check.
[[nodiscard]] Result<FluidMeshResult> fluid_mesh(const Canopy& canopy, const FluidSettings& settings,
                                                 const CanopySurface& surface);

} // namespace drogue::parachute
