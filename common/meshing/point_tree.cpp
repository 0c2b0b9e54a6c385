// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/point_tree.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace drogue::meshing {

struct PointTree::Query {
  Point x;
  double best_square;
  double factor; ///< (1 + relative error)^2
};

PointTree::PointTree(std::vector<Point> points)
    : points_(std::move(points)), low_(Point::Zero()), high_(Point::Zero()) {
  if (points_.empty()) return;
  low_ = high_ = points_.front();
  for (const Point& p : points_) {
    low_ = low_.cwiseMin(p);
    high_ = high_.cwiseMax(p);
  }
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

double PointTree::distance(const Point& x, double cutoff, double relative_error) const {
  Query query{x, cutoff * cutoff, (1 + relative_error) * (1 + relative_error)};
  const Point to_box = (low_ - x).cwiseMax(x - high_).cwiseMax(Point::Zero());
  search(query, 0, points_.size(), 0, to_box);
  return std::sqrt(query.best_square);
}

/// `to_cell`: from the point to the box that holds the range, along each axis.
void PointTree::search(Query& query, std::size_t begin, std::size_t end, int axis,
                       const Point& to_cell) const {
  if (begin == end || to_cell.squaredNorm() * query.factor >= query.best_square) return;
  const std::size_t middle = begin + (end - begin) / 2;
  query.best_square = std::min(query.best_square, (points_[middle] - query.x).squaredNorm());
  const double offset = query.x[axis] - points_[middle][axis];
  const int next = (axis + 1) % 3;
  Point to_far = to_cell;
  to_far[axis] = std::max(to_cell[axis], std::abs(offset));
  search(query, offset < 0 ? begin : middle + 1, offset < 0 ? middle : end, next, to_cell);
  search(query, offset < 0 ? middle + 1 : begin, offset < 0 ? end : middle, next, to_far);
}

} // namespace drogue::meshing
