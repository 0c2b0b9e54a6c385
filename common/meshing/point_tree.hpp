// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>
#include <vector>

#include "common/meshing/tet_mesh.hpp"

namespace drogue::meshing {

/// Balanced k-d tree of points, for the distance to the nearest one: O(log n) a query, no allocation.
class PointTree {
 public:
  explicit PointTree(std::vector<Point> points);
  /// Distance from x to the nearest point, or `cutoff` when none is nearer; at most too large by the factor
  /// 1 + `relative_error`, which makes queries from far away cheap.
  [[nodiscard]] double distance(const Point& x, double cutoff = std::numeric_limits<double>::infinity(),
                                double relative_error = 0) const;

 private:
  struct Query;
  void build(std::size_t begin, std::size_t end, int axis);
  void search(Query& query, std::size_t begin, std::size_t end, int axis, const Point& to_cell) const;

  /// The median of each range is its root; halves follow on both sides; axes take turns.
  std::vector<Point> points_;
  Point low_, high_; ///< bounding box
};

} // namespace drogue::meshing
