// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/triangle_tiling.hpp"

#include <cmath>

#include "coupler/projection/element_matrix.hpp"

namespace drogue::projection {
namespace {

/// How far the parts' areas may miss the whole, relative to it: rounding.
constexpr double area_tolerance = 1e-12;

/// The element across each edge; none where an edge is free or has more than two elements.
std::vector<std::array<std::int32_t, 3>> find_neighbours(const Elements& elements, std::size_t nodes) {
  const auto nodes_of = [&](std::int32_t e) { return elements.nodes(e); };
  const Adjacency around = elements_around(static_cast<std::int32_t>(nodes), elements.count(), nodes_of);
  std::vector<std::array<std::int32_t, 3>> neighbours(static_cast<std::size_t>(elements.count()),
                                                      {-1, -1, -1});
  for (std::int32_t e = 0; e < elements.count(); ++e) {
    const auto n = elements.nodes(e);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = n[k], b = n[(k + 1) % 3];
      std::int32_t found = -1;
      int count = 0;
      for (const std::int32_t f : around.around(a)) {
        const auto m = elements.nodes(f);
        if (f == e || (m[0] != b && m[1] != b && m[2] != b)) continue;
        found = f;
        ++count;
      }
      if (count == 1) neighbours[static_cast<std::size_t>(e)][k] = found;
    }
  }
  return neighbours;
}

} // namespace

TriangleTiling::TriangleTiling(const Elements& elements, std::span<const double> coordinates,
                               std::size_t nodes)
    : elements_(elements),
      coordinates_(coordinates),
      neighbours_(find_neighbours(elements, nodes)),
      seen_(neighbours_.size(), 0) {}

Triangle TriangleTiling::corners(std::int32_t element) const {
  Triangle X;
  const auto nodes = elements_.nodes(element);
  for (std::size_t a = 0; a < 3; ++a)
    X[a] = Eigen::Map<const Eigen::Vector3d>(coordinates_.data() + 3 * static_cast<std::size_t>(nodes[a]));
  return X;
}

bool TriangleTiling::cover(const TriangleFrame& frame, std::int32_t seed, double largest_gap) {
  ++search_;
  tiles_.clear();
  stack_.assign(1, seed);
  seen_[static_cast<std::size_t>(seed)] = search_;
  double area = 0;
  while (!stack_.empty()) {
    const std::int32_t e = stack_.back();
    stack_.pop_back();
    const Overlap o = frame.overlap(corners(e));
    if (o.corners == 0 && e != seed) continue;
    if (o.corners > 0) {
      if (o.gap > largest_gap || (!tiles_.empty() && o.sense != tiles_.front().overlap.sense)) return false;
      area += o.area;
      tiles_.push_back({e, o});
    }
    for (const std::int32_t next : neighbours_[static_cast<std::size_t>(e)]) {
      if (next < 0 || seen_[static_cast<std::size_t>(next)] == search_) continue;
      seen_[static_cast<std::size_t>(next)] = search_;
      stack_.push_back(next);
    }
  }
  return std::abs(area - 0.5) <= 0.5 * area_tolerance;
}

} // namespace drogue::projection
