// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/base/result.hpp"
#include "common/meshing/tet_mesh.hpp"

namespace drogue::meshing {

/// Refuses (ErrorKind::numerical) a membrane around which no volume can be meshed, and names the first edge
/// or pair of triangles with its place: a triangle without area, an edge of more than two triangles,
/// neighbours that face opposite ways, triangles that cross or touch though they share no edge.
[[nodiscard]] Result<void> check_membrane(const std::vector<Point>& points,
                                          const std::vector<Triangle>& membrane);

/// Refuses (ErrorKind::numerical) a membrane whose free edges do not form `loops` loops: a canopy that is
/// torn or sewn up. Names an edge of the smallest loop.
[[nodiscard]] Result<void> check_free_edges(const std::vector<Point>& points,
                                            const std::vector<Triangle>& membrane, std::size_t loops);

/// Distance from a segment to a triangle; 0 where they cross.
[[nodiscard]] double segment_triangle_distance(const std::array<Point, 2>& segment,
                                               const std::array<Point, 3>& triangle);

} // namespace drogue::meshing
