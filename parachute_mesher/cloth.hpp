// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "parachute_mesher/canopy.hpp"

namespace drogue::parachute {

/// Subdivision of a gore: rows of elements along it, elements across it at three places. Of a cross: rows
/// along each arm beside the square in the middle, across_seam elements across an arm.
struct Subdivision {
  int main_rows = 1; ///< without the gaps
  int skirt_rows = 0;
  int across_vent = 1;
  int across_seam = 1;
  int across_skirt = 1;
  /// On the main part the number across grows with this power of the distance from the vent edge.
  double across_exponent = 1;
};

/// Rows of nodes from the vent edge to the skirt edge (of a cross: from the square in the middle to the end
/// of an arm).
struct ClothRows {
  std::vector<double> s;
  std::vector<int> across;   ///< element edges a gore
  std::vector<bool> is_open; ///< of each row: a gap follows
};
/// @pre main_rows > number of gaps
[[nodiscard]] ClothRows cloth_rows(const Canopy& canopy, const Subdivision& subdivision);

/// A mesh of the cloth. The normal of (s, theta)-ordered elements points up on the main part and down on a
/// folded skirt: outward once inflated.
struct Cloth {
  std::vector<ClothNode>
      nodes; ///< corners of elements row by row, then those in the middle of edges and quadrilaterals
  mesh::ElementKind kind = mesh::ElementKind::tri3;
  std::vector<std::int32_t> elements;
  /// Nodes along each line of reinforcement: round canopies along each gore boundary from the vent edge to
  /// the skirt edge, across gaps; a cross from the end of an arm to that of the arm opposite.
  std::vector<std::vector<std::int32_t>> radials;
  std::vector<std::int32_t> vent;  ///< where vent lines begin
  std::vector<std::int32_t> skirt; ///< where suspension lines begin, in the order of theta from 0 to 2 pi
  std::vector<std::int32_t> rim;   ///< all corners on the skirt edge, on a cross at the ends of the arms
};

/// Three-node triangles; between rows of different counts the shorter diagonal is taken.
[[nodiscard]] Cloth triangulate_cloth(const Canopy& canopy, const ClothRows& rows);

/// A cloth of tri3, tri6, quad4 or quad9. @pre quadrilaterals: every row has the same number across
[[nodiscard]] Cloth mesh_cloth(const Canopy& canopy, const ClothRows& rows, mesh::ElementKind kind);

} // namespace drogue::parachute
