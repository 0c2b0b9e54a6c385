// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/base/result.hpp"
#include "common/mesh/mesh.hpp"

namespace drogue::meshing {

/// remesh() of a plane mesh: triangles of one group in a plane z = const, boundaries of two-node lines.
[[nodiscard]] Result<mesh::Mesh> remesh_plane(const mesh::Mesh& old);

} // namespace drogue::meshing
