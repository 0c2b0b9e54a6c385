// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "common/meshing/tet_mesh.hpp"

namespace drogue::meshing {

/// nx x ny x nz unit cubes of six tets each (Kuhn's subdivision). Boundaries "inflow" (z = 0), "outflow" (z =
/// nz) and "side".
[[nodiscard]] TetMesh kuhn_grid(int nx, int ny, int nz);

/// The faces between tets whose centre satisfies `selected` and that lie in a plane of the grid normal to
/// `axis`, with normals along it.
[[nodiscard]] std::vector<Triangle> grid_faces(const TetMesh& grid, int axis,
                                               const std::function<bool(const Point&)>& selected);

/// Drops triangles with all three nodes on free edges: corners that cannot be cut open.
[[nodiscard]] std::vector<Triangle> without_corners(std::vector<Triangle> surface);

} // namespace drogue::meshing
