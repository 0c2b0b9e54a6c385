// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/line_refinement.hpp"

namespace drogue::projection {
namespace {

/// How near to one another two breaks, or a break and an end, may be found: a kink that is misplaced by this
/// changes an integral by its square.
constexpr double resolution = 1e-12;
/// Where elements of the other mesh lie on one another the closest one may change in every point.
constexpr std::size_t most_breaks = 1000;

/// Finds the changes of the closest element by bisection.
struct Search {
  mesh::ElementKind kind;
  const NodeMatrix& X;
  const SurfaceTree& other;
  std::vector<double> breaks{-1.0};

  [[nodiscard]] std::int32_t at(double s, std::int32_t hint) const {
    const auto shape = element_shape(kind, s, 0);
    return other.closest(combine(shape.N, shape.nodes, X), hint).element;
  }
  void split(double a, std::int32_t on_a, double b, std::int32_t on_b) {
    if (on_a == on_b || breaks.size() >= most_breaks) return;
    const double middle = 0.5 * (a + b);
    if (b - a <= resolution) {
      breaks.push_back(middle);
      return;
    }
    const std::int32_t on_middle = at(middle, on_a);
    split(a, on_a, middle, on_middle);
    split(middle, on_middle, b, on_b);
  }
};

} // namespace

std::vector<double> refine_line(mesh::ElementKind kind, const NodeMatrix& X, const SurfaceTree& other) {
  Search search{kind, X, other};
  // Just inside the ends, where a node of the other mesh often lies.
  const double end = 1 - 1e-9;
  const std::int32_t first = search.at(-end, -1);
  search.split(-end, first, end, search.at(end, first));
  search.breaks.push_back(1.0);
  return std::move(search.breaks);
}

std::vector<fem::SurfacePoint> line_quadrature(std::span<const double> breaks, int degree) {
  const auto base = element_quadrature(mesh::ElementKind::line2, degree);
  std::vector<fem::SurfacePoint> rule;
  for (std::size_t i = 1; i < breaks.size(); ++i) {
    const double half = 0.5 * (breaks[i] - breaks[i - 1]), middle = 0.5 * (breaks[i] + breaks[i - 1]);
    for (const fem::SurfacePoint& q : base) rule.push_back({middle + half * q.xi, 0, half * q.weight});
  }
  return rule;
}

} // namespace drogue::projection
