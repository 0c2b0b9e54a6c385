// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/meshing/box_mesher.hpp"
#include "common/meshing/node_doubling.hpp"
#include "common/meshing/repair.hpp"
#include "common/meshing/size_field.hpp"

namespace drogue::meshing {

struct MembraneVolume {
  /// Boundaries "inflow", "outflow", "side", and the two sides of the membrane.
  TetMesh mesh;
  SplitSummary split;
  std::int32_t smoothing_moves = 0;
  DoublingSummary doubling;
};

/// The volume of a box around an open membrane: meshed, repaired, cut open along the membrane and checked
/// (check_volume, check_two_sided). A mesh with a dihedral angle below 8 degrees is made again with sizes a
/// little different, five times at most; the best one counts. The first nodes of the mesh are `points`. As to
/// repeated calls see mesh_box.
///
/// Errors (ErrorKind::numerical): as check_membrane, mesh_box, double_nodes and the checks: a mesh that fails
/// one is never returned.
[[nodiscard]] Result<MembraneVolume> mesh_membrane_volume(const Box& box, const std::vector<Point>& points,
                                                          const std::vector<Triangle>& membrane,
                                                          const SizeRule& sizes, const std::string& upper,
                                                          const std::string& lower);

} // namespace drogue::meshing
