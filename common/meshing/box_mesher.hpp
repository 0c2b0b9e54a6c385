// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/base/result.hpp"
#include "common/meshing/gmsh_volume.hpp"

namespace drogue::meshing {

struct Box {
  Point low = Point::Zero();
  Point high = Point::Zero();
};

/// Meshes a box around an embedded open surface with Gmsh (HXT, one thread: with more it may give a mesh that
/// does not conform). The result's first nodes are `points`, unmoved; its interior surface is `surface`; its
/// boundaries are "inflow" (lowest z), "outflow" (highest z) and "side".
///
/// Every fresh process makes the same mesh of the same input. A second call in one process may give another
/// mesh, as good as the first: Gmsh orders nodes by their addresses.
///
/// Errors: ErrorKind::numerical when the surface does not lie inside the box, or Gmsh cannot mesh it (its
/// last error, e.g. a surface that intersects itself) or does not keep it.
[[nodiscard]] Result<TetMesh> mesh_box(const Box& box, const std::vector<Point>& points,
                                       const std::vector<Triangle>& surface, const SizeFunction& size);

} // namespace drogue::meshing
