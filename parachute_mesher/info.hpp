// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "common/base/result.hpp"
#include "common/mesh/mesh.hpp"

namespace drogue::parachute {

/// What a mesh holds, as text: nodes, bounding box, node fields; every group with its elements, nodes and
/// length, area or volume; quality of tetrahedra and whether they pass the checks of common/meshing; the
/// topology of a canopy.
[[nodiscard]] std::string describe(const mesh::Mesh& m);

/// Whether the tetrahedra of a mesh, if it has any, pass the checks of common/meshing, and a canopy closes.
/// Errors (ErrorKind::numerical): they do not; says where.
[[nodiscard]] Result<void> check(const mesh::Mesh& m);

/// Length, area or volume of a block, 0 for points; curved elements by quadrature.
[[nodiscard]] double measure(const mesh::Mesh& m, const mesh::ElementBlock& block);

} // namespace drogue::parachute
