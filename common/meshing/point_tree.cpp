// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/point_tree.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace drogue::meshing {

PointTree::PointTree(std::vector<Point> points) : points_(std::move(points)) {
  build(0, points_.size(), 0);
}

void PointTree::build(std::size_t begin, std::size_t end, int axis) {
  if (end - begin < 2) return;
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::size_t i) { return points_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end),
                   [axis](const Point& a, const Point& b) { return a[axis] < b[axis]; });
  build(begin, middle, (axis + 1) % 3);
  build(middle + 1, end, (axis + 1) % 3);
}

double PointTree::distance(const Point& x, double cutoff) const {
  double best_square = cutoff * cutoff;
  search(x, 0, points_.size(), 0, best_square);
  return std::sqrt(best_square);
}

void PointTree::search(const Point& x, std::size_t begin, std::size_t end, int axis,
                       double& best_square) const {
  if (begin == end) return;
  const std::size_t middle = begin + (end - begin) / 2;
  best_square = std::min(best_square, (points_[middle] - x).squaredNorm());
  const double offset = x[axis] - points_[middle][axis];
  const int next = (axis + 1) % 3;
  const auto left = [&] { search(x, begin, middle, next, best_square); };
  const auto right = [&] { search(x, middle + 1, end, next, best_square); };
  offset < 0 ? left() : right();
  if (offset * offset < best_square) offset < 0 ? right() : left();
}

} // namespace drogue::meshing
