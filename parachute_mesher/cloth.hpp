// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace drogue::parachute {

/// A flat extended-skirt canopy: a disk with a vent, and an inverted ring (the skirt) folded under it and
/// joined to it at the seam. The cloth coordinate s is the length along a gore from the apex: vent edge
/// s_vent, seam s_seam, skirt edge s_skirt. The gore boundaries (radials) stand at theta = 2 pi (g + 1/2) /
/// gores.
struct Canopy {
  double diameter = 0; ///< constructed diameter Dc [length]
  double vent_ratio = 0;
  double skirt_ratio = 0;
  int gores = 0;

  [[nodiscard]] double s_vent() const { return 0.5 * vent_ratio * diameter; }
  [[nodiscard]] double s_seam() const { return 0.5 * diameter; }
  [[nodiscard]] double s_skirt() const { return (0.5 + skirt_ratio) * diameter; }
  /// Radius in the flat pattern: s on the disk, Dc - s on the folded skirt.
  [[nodiscard]] double flat_radius(double s) const { return s <= s_seam() ? s : diameter - s; }
  /// Area of the cloth: disk without vent, and skirt.
  [[nodiscard]] double cloth_area() const;
};

/// Subdivision of a gore: rows of elements along it, elements across it at three places.
struct Subdivision {
  int main_rows = 1;
  int skirt_rows = 0;
  int across_vent = 1;
  int across_seam = 1;
  int across_skirt = 1;
  /// On the disk the number across grows with this power of the distance from the vent edge.
  double across_exponent = 1;
};

/// Rows of nodes from the vent edge to the skirt edge: their s, and the number of element edges a gore.
struct ClothRows {
  std::vector<double> s;
  std::vector<int> across;
};
[[nodiscard]] ClothRows cloth_rows(const Canopy& canopy, const Subdivision& subdivision);

struct ClothNode {
  double s = 0;
  double theta = 0;
};

/// A mesh of the cloth. The normal of (s, theta)-ordered elements points up on the flat disk and down on the
/// folded skirt: outward once inflated.
struct Cloth {
  std::vector<ClothNode> nodes; ///< row by row, each row around the canopy
  mesh::ElementKind kind = mesh::ElementKind::tri3;
  std::vector<std::int32_t> elements;
  /// Nodes along each gore boundary from the vent edge to the skirt edge, shape {gores, rows}.
  std::vector<std::vector<std::int32_t>> radials;
};

/// Three-node triangles between the rows; between rows of different counts the shorter diagonal is taken.
[[nodiscard]] Cloth triangulate_cloth(const Canopy& canopy, const ClothRows& rows);

/// Nine-node quadrilaterals. @pre every row has the same number across
[[nodiscard]] Cloth quadratic_cloth(const Canopy& canopy, const ClothRows& rows);

/// Position in the flat pattern (z = 0, the skirt folded under the disk).
[[nodiscard]] std::array<double, 3> flat_position(const Canopy& canopy, const ClothNode& node);
/// Position in the unfolded pattern, unique on the cloth: (s cos theta, s sin theta, 0).
[[nodiscard]] std::array<double, 3> material_position(const ClothNode& node);

} // namespace drogue::parachute
