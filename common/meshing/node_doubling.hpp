// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "common/base/result.hpp"
#include "common/meshing/tet_mesh.hpp"

namespace drogue::meshing {

struct DoublingSummary {
  std::int32_t single_nodes = 0;  ///< on the free edges
  std::int32_t doubled_nodes = 0; ///< elsewhere on the surface
  /// For every node of the new mesh the node of the old one it was; the first ones are the old nodes
  /// themselves.
  std::vector<std::int32_t> origin;
};

/// Cuts the volume open along its interior surface: the fluid gets two sides with a node each, the free edges
/// keep single nodes. The interior surface becomes the boundaries `upper` (on the side its normal points to)
/// and `lower`, triangle by triangle in the same order; normals point out of the volume.
///
/// Which tets around a node hang together is found by union-find over tet corners joined across every face
/// that is not on the surface, so that folds that nearly touch are no special case.
///
/// Errors (ErrorKind::numerical): a triangle of the surface that is not a face of two tets, one on each side,
/// or a node around which the surface separates more than two regions.
[[nodiscard]] Result<DoublingSummary> double_nodes(TetMesh& m, const std::string& upper,
                                                   const std::string& lower);

} // namespace drogue::meshing
