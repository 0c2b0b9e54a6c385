// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tests/verification/fluid_meshes.hpp"

namespace drogue::fluid::test {

/// Meshes Gmsh's current model, a plane surface, and takes its triangles, as the group `fluid`, and the edges
/// of the named groups of curves. @pre the model is synchronised
[[nodiscard]] mesh::Mesh triangulated(int surface,
                                      const std::vector<std::pair<std::string, std::vector<int>>>& curves,
                                      const PlaneSize& size);

} // namespace drogue::fluid::test
