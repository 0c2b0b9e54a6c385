// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/meshing/gmsh_volume.hpp"

namespace drogue::meshing {

/// Fills a region of the plane z = const with triangles (Gmsh). `loops` are its closed boundaries, edge
/// after edge, the first the outer one. The result's first nodes are the edges' first ones, in their order;
/// `tets` is empty, the triangles are its `interior`.
///
/// Errors: ErrorKind::numerical when Gmsh cannot mesh it (its last error), or cuts an edge.
[[nodiscard]] Result<TetMesh> mesh_region(const std::vector<Point>& points,
                                          const std::vector<std::vector<Edge>>& loops,
                                          const SizeFunction& size);

} // namespace drogue::meshing
