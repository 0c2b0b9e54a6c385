// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/simplex_locator.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include <Eigen/Geometry>

namespace drogue::meshing {
namespace {

using Index = std::size_t;

constexpr Index leaf_size = 4;
/// Boxes are larger than their cells by this part of their size, for points on faces.
constexpr double margin = 1e-6;
/// A smallest weight above this counts as inside.
constexpr double inside = -1e-12;

constexpr Index middle_of(Index begin, Index end) {
  return begin + (end - begin) / 2;
}

} // namespace

template <std::size_t D>
double SimplexPlace<D>::smallest() const {
  return cell < 0 ? -std::numeric_limits<double>::infinity()
                  : *std::min_element(weight.begin(), weight.end());
}

template <std::size_t D>
SimplexLocator<D>::SimplexLocator(std::span<const Point> points, std::span<const Cell> cells)
    : points_(points), cells_(cells), order_(cells.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  std::vector<Point> centres;
  centres.reserve(cells.size());
  for (const Cell& cell : cells) {
    Point sum = Point::Zero();
    for (const std::int32_t node : cell) sum += points[static_cast<Index>(node)];
    centres.push_back(sum / static_cast<double>(D + 1));
  }
  Index nodes = 1;
  for (Index leaf = cells.size(); leaf > leaf_size; leaf = (leaf + 1) / 2) nodes = 2 * nodes + 1;
  boxes_.resize(nodes);
  if (!cells.empty()) build(0, 0, cells.size(), centres);
}

template <std::size_t D>
void SimplexLocator<D>::build(Index node, Index begin, Index end, const std::vector<Point>& centres) {
  Box& box = boxes_[node];
  box.low.setConstant(std::numeric_limits<double>::infinity());
  box.high = -box.low;
  Point low = box.low, high = box.high; // of the centres
  for (Index i = begin; i < end; ++i) {
    const auto e = static_cast<Index>(order_[i]);
    for (const std::int32_t corner : cells_[e]) {
      box.low = box.low.cwiseMin(points_[static_cast<Index>(corner)]);
      box.high = box.high.cwiseMax(points_[static_cast<Index>(corner)]);
    }
    low = low.cwiseMin(centres[e]);
    high = high.cwiseMax(centres[e]);
  }
  const Point gap = margin * (box.high - box.low).cwiseMax(1e-3 * (box.high - box.low).maxCoeff());
  box.low -= gap;
  box.high += gap;
  if (end - begin <= leaf_size) return;
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const Index middle = middle_of(begin, end);
  const auto at = [&](Index i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](std::int32_t a, std::int32_t b) {
    const double xa = centres[static_cast<Index>(a)][axis], xb = centres[static_cast<Index>(b)][axis];
    return xa != xb ? xa < xb : a < b;
  });
  build(2 * node + 1, begin, middle, centres);
  build(2 * node + 2, middle, end, centres);
}

template <std::size_t D>
SimplexPlace<D> SimplexLocator<D>::place(std::int32_t cell, const Point& x) const {
  const Cell& nodes = cells_[static_cast<Index>(cell)];
  const auto edge = [&](Index a) -> Point {
    return points_[static_cast<Index>(nodes[a])] - points_[static_cast<Index>(nodes[0])];
  };
  const Point d = x - points_[static_cast<Index>(nodes[0])];
  Place p;
  p.cell = cell;
  if constexpr (D == 2) {
    const Point a = edge(1), b = edge(2);
    const double scale = 1 / (a.x() * b.y() - a.y() * b.x());
    p.weight[1] = scale * (d.x() * b.y() - d.y() * b.x());
    p.weight[2] = scale * (a.x() * d.y() - a.y() * d.x());
    p.weight[0] = 1 - p.weight[1] - p.weight[2];
  } else {
    const Point a = edge(1), b = edge(2), c = edge(3), bc = b.cross(c), da = d.cross(a);
    const double scale = 1 / a.dot(bc);
    p.weight[1] = scale * d.dot(bc);
    p.weight[2] = -scale * c.dot(da);
    p.weight[3] = scale * b.dot(da);
    p.weight[0] = 1 - p.weight[1] - p.weight[2] - p.weight[3];
  }
  return p;
}

template <std::size_t D>
SimplexPlace<D> SimplexLocator<D>::find(const Point& x, std::int32_t guess) const {
  Place best;
  if (guess >= 0) best = place(guess, x);
  if (best.smallest() < inside && !cells_.empty()) search(0, 0, cells_.size(), x, best);
  return best;
}

template <std::size_t D>
void SimplexLocator<D>::search(Index node, Index begin, Index end, const Point& x, Place& best) const {
  const Box& box = boxes_[node];
  if ((x.array() < box.low.array()).any() || (x.array() > box.high.array()).any()) return;
  if (end - begin <= leaf_size) {
    for (Index i = begin; i < end; ++i) {
      const Place candidate = place(order_[i], x);
      if (candidate.smallest() > best.smallest()) best = candidate;
    }
    return;
  }
  const Index middle = middle_of(begin, end);
  search(2 * node + 1, begin, middle, x, best);
  if (best.smallest() < inside) search(2 * node + 2, middle, end, x, best);
}

template struct SimplexPlace<2>;
template struct SimplexPlace<3>;
template class SimplexLocator<2>;
template class SimplexLocator<3>;

} // namespace drogue::meshing
