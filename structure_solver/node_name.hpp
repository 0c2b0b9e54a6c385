// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

#include "common/mesh/mesh.hpp"

namespace drogue::structure {

/// A node in words: its number, its reference position and the groups it belongs to.
[[nodiscard]] std::string node_name(const mesh::Mesh& mesh, std::int32_t node);

} // namespace drogue::structure
