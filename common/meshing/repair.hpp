// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/meshing/tet_mesh.hpp"

namespace drogue::meshing {

struct SplitSummary {
  std::int32_t tets_before = 0; ///< tets with all four nodes on the interior surface
  std::int32_t edges_split = 0; ///< by a node in their middle
  std::int32_t tets_split = 0;  ///< by a node in their centre, when all six edges lie on the surface
};

/// Leaves no tet with all four nodes on the interior surface: such tets lock the flow inside a fold and
/// cannot follow the surface's motion. Edges that bridge a fold are split in the middle, the longest first.
SplitSummary split_bridges(TetMesh& m);

/// Moves the free nodes (neither on a boundary nor on the interior surface) of tets whose mean ratio is below
/// `threshold` by pattern search; a move is kept only when the worst tet around the node gets better. Stops
/// after `sweeps` sweeps or when nothing moves. Returns the number of moves.
std::int32_t smooth_bad_tets(TetMesh& m, double threshold, int sweeps);

} // namespace drogue::meshing
