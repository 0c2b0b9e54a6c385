// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "common/meshing/tet_mesh.hpp"

namespace drogue::meshing {

/// A point's tet and its barycentric coordinates there: values at the corners times these give the value at
/// the point.
struct TetPlace {
  std::int32_t tet = -1; ///< -1: no tet is near
  std::array<double, 4> weight{};
  [[nodiscard]] double smallest() const;
};

/// Finds the tet around a point, by a tree of boxes.
class TetLocator {
 public:
  /// Both must outlive this.
  TetLocator(std::span<const Point> points, std::span<const Tet> tets);
  /// The tet that holds x, `guess` if it does. When none does (x lies outside, be it by rounding) that of the
  /// tets whose box holds x in which the smallest weight is largest.
  [[nodiscard]] TetPlace find(const Point& x, std::int32_t guess = -1) const;

 private:
  struct Box {
    Point low, high;
  };
  void build(std::size_t node, std::size_t begin, std::size_t end, const std::vector<Point>& centres);
  [[nodiscard]] TetPlace place(std::int32_t tet, const Point& x) const;
  void search(std::size_t node, std::size_t begin, std::size_t end, const Point& x, TetPlace& best) const;

  std::span<const Point> points_;
  std::span<const Tet> tets_;
  std::vector<std::int32_t> order_; ///< tets by leaf
  std::vector<Box> boxes_;          ///< of a binary tree; node k has the children 2 k + 1 and 2 k + 2
};

} // namespace drogue::meshing
