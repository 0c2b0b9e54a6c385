// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "mesh_mover/cells.hpp"

namespace drogue::mesh_mover {

/// A numbering of the nodes in which neighbours are close: reverse Cuthill-McKee. The matrix then streams
/// through the cache, and incomplete factors are better than in the order of a mesh generator. Returns the
/// new number of every node.
[[nodiscard]] std::vector<std::int32_t> reverse_cuthill_mckee(const Cells& cells, std::size_t node_count);

} // namespace drogue::mesh_mover
