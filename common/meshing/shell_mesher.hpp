// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/meshing/gmsh_volume.hpp"
#include "common/meshing/merged_surface.hpp"

namespace drogue::meshing {

/// Fills a closed surface, with holes and membranes inside, with tets (Gmsh, HXT, one thread). The result's
/// first nodes are surface.points, unmoved; its only boundary holds the shells, its interior surface the
/// sheets. As to repeated calls see mesh_box.
///
/// Errors: ErrorKind::numerical when Gmsh cannot mesh it (its last error), or does not keep the surface.
[[nodiscard]] Result<TetMesh> mesh_shells(const MergedSurface& surface, const SizeFunction& size);

} // namespace drogue::meshing
