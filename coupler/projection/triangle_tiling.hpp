// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coupler/projection/surface.hpp"
#include "coupler/projection/triangle_overlap.hpp"

namespace drogue::projection {

/// The common refinement of a surface of linear triangles with single triangles of another one.
class TriangleTiling {
 public:
  struct Tile {
    std::int32_t element = -1;
    Overlap overlap;
  };

  /// @pre all elements are tri3; both arguments must outlive this
  TriangleTiling(const Elements& elements, std::span<const double> coordinates, std::size_t nodes);

  /// Finds the elements that cover the triangle of the frame, from `seed` on across their edges: so that only
  /// the sheet that the seed belongs to takes part. False when they do not cover it as a whole (a free edge),
  /// or not as a graph over its plane (a fold), or further from it than `largest_gap`.
  [[nodiscard]] bool cover(const TriangleFrame& frame, std::int32_t seed, double largest_gap);
  /// What the last cover() found.
  [[nodiscard]] const std::vector<Tile>& tiles() const { return tiles_; }
  [[nodiscard]] Triangle corners(std::int32_t element) const;

 private:
  const Elements& elements_;
  std::span<const double> coordinates_;
  std::vector<std::array<std::int32_t, 3>> neighbours_; ///< across the edge from corner k to k + 1; -1: none
  std::vector<std::int32_t> seen_;                      ///< {elements}: the last search that met it
  std::int32_t search_ = 0;
  std::vector<std::int32_t> stack_;
  std::vector<Tile> tiles_;
};

} // namespace drogue::projection
