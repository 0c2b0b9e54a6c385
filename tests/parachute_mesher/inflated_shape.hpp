// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/mesh/mesh.hpp"
#include "parachute_mesher/cloth.hpp"

namespace drogue::parachute {

/// Displacement of a structure mesh's canopy from the flat pattern to a shape much like an inflated canopy:
/// elliptic meridians along the gore boundaries with the seam at the equator, and gores that bulge between
/// them as circular arcs. Nodes that are not on the cloth do not move.
/// @param fullness the part of a gore's width beyond the chord that its arc has: at 1 neighbours nearly touch
[[nodiscard]] std::vector<double> inflated_displacement(const Canopy& canopy, const mesh::Mesh& structure,
                                                        double fullness = 0.35);

} // namespace drogue::parachute
