// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/mesh/mesh.hpp"
#include "parachute_mesher/settings.hpp"

namespace drogue::parachute {

/// The structure in its reference configuration: the constructed cloth with its apex at the origin, vent
/// lines to the apex, suspension lines straight to the confluence points below (z < 0), risers and payload
/// below these. With the paper's subdivision this is its incompatible mesh [stein2001, "Numerical
/// Simulations"]: 3,573 nodes, 780 Q9, 870 + 300 cables; with risers and payload 3,595 nodes, 20 more cables
/// and 6 trusses.
///
/// Node field "material": the unfolded pattern on the cloth, NaN elsewhere.
[[nodiscard]] mesh::Mesh structure_mesh(const Canopy& canopy, const Rigging& rigging,
                                        const StructureSettings& settings);

} // namespace drogue::parachute
