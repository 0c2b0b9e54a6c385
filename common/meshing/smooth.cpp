// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/meshing/quality.hpp"
#include "common/meshing/repair.hpp"

namespace drogue::meshing {
namespace {

using Index = std::size_t;

/// Of the mean ratio, for a move to count: without it the search creeps.
constexpr double smallest_gain = 1e-3;

std::vector<bool> fixed_nodes(const TetMesh& m) {
  std::vector<bool> fixed(m.points.size(), false);
  const auto fix = [&](const std::vector<Triangle>& triangles) {
    for (const Triangle& t : triangles)
      for (const std::int32_t node : t) fixed[static_cast<Index>(node)] = true;
  };
  for (const NamedSurface& surface : m.boundaries) fix(surface.triangles);
  fix(m.interior);
  return fixed;
}

/// A node and the tets around it.
struct Star {
  TetMesh& m;
  std::int32_t node;
  std::span<const std::int32_t> tets;

  [[nodiscard]] Point& position() const { return m.points[static_cast<Index>(node)]; }
  /// Worst mean ratio; stops early below `enough`.
  [[nodiscard]] double worst(double enough) const {
    double q = std::numeric_limits<double>::infinity();
    for (const std::int32_t e : tets) {
      q = std::min(q, mean_ratio(m.points, m.tets[static_cast<Index>(e)]));
      if (q <= enough) break;
    }
    return q;
  }
  [[nodiscard]] Point centre() const {
    Point sum = Point::Zero();
    for (const std::int32_t e : tets)
      for (const std::int32_t other : m.tets[static_cast<Index>(e)])
        if (other != node) sum += m.points[static_cast<Index>(other)];
    return sum / (3.0 * static_cast<double>(tets.size()));
  }
  [[nodiscard]] double shortest_edge() const {
    double l2 = std::numeric_limits<double>::infinity();
    for (const std::int32_t e : tets)
      for (const std::int32_t other : m.tets[static_cast<Index>(e)])
        if (other != node)
          l2 = std::min(l2, (m.points[static_cast<Index>(other)] - position()).squaredNorm());
    return std::sqrt(l2);
  }
};

/// Moves the node to `x` if that makes the worst tet better than `best`.
bool try_move(const Star& star, const Point& x, double& best) {
  const Point old = star.position();
  star.position() = x;
  const double q = star.worst(best);
  if (q > best + smallest_gain) {
    best = q;
    return true;
  }
  star.position() = old;
  return false;
}

/// Pattern search along the axes and diagonals of a cube with halving steps.
bool improve(const Star& star) {
  double best = star.worst(-std::numeric_limits<double>::infinity());
  bool moved = try_move(star, star.centre(), best);
  if (!moved) moved = try_move(star, 0.5 * (star.centre() + star.position()), best);
  double step = 0.4 * std::max(star.shortest_edge(), 0.1 * (star.centre() - star.position()).norm());
  for (int halvings = 0; halvings < 6;) {
    bool better = false;
    for (int k = 0; k < 27 && !better; ++k) {
      const Point direction(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      if (k != 13) better = try_move(star, star.position() + step * direction.normalized(), best);
    }
    moved = moved || better;
    if (better) continue;
    step *= 0.5;
    ++halvings;
  }
  return moved;
}

} // namespace

std::int32_t smooth_bad_tets(TetMesh& m, double threshold, int sweeps) {
  const std::vector<bool> fixed = fixed_nodes(m);
  const NodeTets node_tets(m.points.size(), m.tets);
  std::int32_t moves = 0;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    std::vector<bool> active(m.points.size(), false);
    for (const Tet& tet : m.tets)
      if (mean_ratio(m.points, tet) < threshold)
        for (const std::int32_t node : tet) active[static_cast<Index>(node)] = true;
    std::int32_t moved = 0;
    for (Index node = 0; node < active.size(); ++node) {
      const auto i = static_cast<std::int32_t>(node);
      if (active[node] && !fixed[node]) moved += improve({m, i, node_tets.of(i)});
    }
    moves += moved;
    if (moved == 0) break;
  }
  return moves;
}

} // namespace drogue::meshing
