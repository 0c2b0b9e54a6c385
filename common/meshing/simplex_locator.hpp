// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "common/meshing/tet_mesh.hpp"

namespace drogue::meshing {

/// The cell of a point, a triangle (D = 2) or a tetrahedron (D = 3), and the point's barycentric coordinates
/// there: values at the corners times these give the value at the point.
template <std::size_t D>
struct SimplexPlace {
  std::int32_t cell = -1; ///< -1: none is near
  std::array<double, D + 1> weight{};
  [[nodiscard]] double smallest() const;
};

/// Finds the cell around a point, by a tree of boxes. Triangles lie in a plane z = const.
template <std::size_t D>
class SimplexLocator {
 public:
  using Cell = std::array<std::int32_t, D + 1>;
  using Place = SimplexPlace<D>;
  /// Both must outlive this.
  SimplexLocator(std::span<const Point> points, std::span<const Cell> cells);
  /// The cell that holds x, `guess` if it does. When none does (x lies outside, be it by rounding) that of
  /// the cells whose box holds x in which the smallest weight is largest.
  [[nodiscard]] Place find(const Point& x, std::int32_t guess = -1) const;
  /// The coordinates of any point in a cell.
  [[nodiscard]] Place place(std::int32_t cell, const Point& x) const;

 private:
  struct Box {
    Point low, high;
  };
  void build(std::size_t node, std::size_t begin, std::size_t end, const std::vector<Point>& centres);
  void search(std::size_t node, std::size_t begin, std::size_t end, const Point& x, Place& best) const;

  std::span<const Point> points_;
  std::span<const Cell> cells_;
  std::vector<std::int32_t> order_; ///< cells by leaf
  std::vector<Box> boxes_;          ///< of a binary tree; node k has the children 2 k + 1 and 2 k + 2
};

using TetPlace = SimplexPlace<3>;
using TetLocator = SimplexLocator<3>;

} // namespace drogue::meshing
