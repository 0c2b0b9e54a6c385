// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/base/result.hpp"
#include "common/meshing/tet_mesh.hpp"

namespace drogue::meshing {

/// Refuses (ErrorKind::numerical, says what, how many, and where the first is) a mesh that a solver could not
/// trust: tets without positive volume; faces of more than two tets; faces of one tet that are not exactly
/// the triangles of the named boundaries, each once and with its normal outward; nodes without tets; nodes
/// whose tets are not connected through faces. @pre no interior surface
[[nodiscard]] Result<void> check_volume(const TetMesh& m);

/// Euler characteristic V - E + F of a surface.
[[nodiscard]] std::int32_t euler_characteristic(const std::vector<Triangle>& triangles);

/// Pieces of a surface that are connected through nodes.
[[nodiscard]] std::int32_t piece_count(const std::vector<Triangle>& triangles);

/// Refuses a two-sided membrane whose sides together are not one closed, oriented surface: every edge must
/// belong to two triangles, in opposite directions, and the Euler characteristic be 4 c - 2 n for c pieces
/// with n free-edge loops (a canopy with a vent, n = 2, is a torus: 0).
[[nodiscard]] Result<void> check_two_sided(const std::vector<Triangle>& upper,
                                           const std::vector<Triangle>& lower);

} // namespace drogue::meshing
