// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parachute_mesher/cloth.hpp"

namespace drogue::parachute {

/// The cloth of a cross, elements with corners alone. @param kind tri3 or quad4
[[nodiscard]] Cloth cross_cloth(const Canopy& canopy, const ClothRows& rows, mesh::ElementKind kind);

} // namespace drogue::parachute
