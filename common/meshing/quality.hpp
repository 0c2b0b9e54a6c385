// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/meshing/tet_mesh.hpp"

namespace drogue::meshing {

/// Signed volume.
[[nodiscard]] double volume(const std::vector<Point>& x, const Tet& tet);

/// Mean ratio 12 (3 V)^(2/3) / sum of the squared edges: 1 for a regular tet, 0 for a flat one, negative for
/// an inverted one.
[[nodiscard]] double mean_ratio(const std::vector<Point>& x, const Tet& tet);

/// Smallest angle between two faces, in degrees (70.5 for a regular tet).
[[nodiscard]] double smallest_dihedral_angle(const std::vector<Point>& x, const Tet& tet);

/// The same of a triangle in a plane z = const: mean ratio 4 sqrt(3) A / sum of the squared edges, negative
/// when it runs clockwise, and smallest angle between two edges (60 for a regular one).
[[nodiscard]] double mean_ratio(const std::vector<Point>& x, const Triangle& t);
[[nodiscard]] double smallest_angle(const std::vector<Point>& x, const Triangle& t);

struct QualitySummary {
  double smallest_volume = 0;
  double total_volume = 0;
  double smallest_mean_ratio = 0;
  double smallest_angle = 0; ///< dihedral, degrees
  std::int32_t below_5_degrees = 0;
  std::int32_t below_10_degrees = 0;
};
[[nodiscard]] QualitySummary summarise_quality(const std::vector<Point>& x, const std::vector<Tet>& tets);

} // namespace drogue::meshing
