// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/quality.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

namespace drogue::meshing {
namespace {

const Point& at(const std::vector<Point>& x, std::int32_t node) {
  return x[static_cast<std::size_t>(node)];
}

} // namespace

double volume(const std::vector<Point>& x, const Tet& tet) {
  const Point& o = at(x, tet[0]);
  return (at(x, tet[1]) - o).dot((at(x, tet[2]) - o).cross(at(x, tet[3]) - o)) / 6;
}

double mean_ratio(const std::vector<Point>& x, const Tet& tet) {
  double squares = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j) squares += (at(x, tet[i]) - at(x, tet[j])).squaredNorm();
  if (squares == 0) return 0;
  const double root = std::cbrt(3 * volume(x, tet));
  return std::copysign(12 * root * root / squares, root);
}

double smallest_dihedral_angle(const std::vector<Point>& x, const Tet& tet) {
  std::array<Point, 4> normal;
  for (int f = 0; f < 4; ++f) {
    const Triangle t = face_of(tet, f);
    normal[static_cast<std::size_t>(f)] =
        (at(x, t[1]) - at(x, t[0])).cross(at(x, t[2]) - at(x, t[0])).stableNormalized();
  }
  double smallest = std::numbers::pi;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j)
      smallest = std::min(smallest, std::acos(std::clamp(-normal[i].dot(normal[j]), -1.0, 1.0)));
  return smallest * 180 / std::numbers::pi;
}

double mean_ratio(const std::vector<Point>& x, const Triangle& t) {
  const Point a = at(x, t[1]) - at(x, t[0]), b = at(x, t[2]) - at(x, t[0]);
  const double squares = a.squaredNorm() + b.squaredNorm() + (b - a).squaredNorm();
  return squares == 0 ? 0 : 2 * std::numbers::sqrt3 * (a.x() * b.y() - a.y() * b.x()) / squares;
}

double smallest_angle(const std::vector<Point>& x, const Triangle& t) {
  double smallest = std::numbers::pi;
  for (std::size_t i = 0; i < 3; ++i) {
    const Point a = (at(x, t[(i + 1) % 3]) - at(x, t[i])).stableNormalized(),
                b = (at(x, t[(i + 2) % 3]) - at(x, t[i])).stableNormalized();
    smallest = std::min(smallest, std::acos(std::clamp(a.dot(b), -1.0, 1.0)));
  }
  return smallest * 180 / std::numbers::pi;
}

QualitySummary summarise_quality(const std::vector<Point>& x, const std::vector<Tet>& tets) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  QualitySummary q{.smallest_volume = infinity, .smallest_mean_ratio = infinity, .smallest_angle = infinity};
  for (const Tet& tet : tets) {
    const double v = volume(x, tet), angle = smallest_dihedral_angle(x, tet);
    q.smallest_volume = std::min(q.smallest_volume, v);
    q.total_volume += v;
    q.smallest_mean_ratio = std::min(q.smallest_mean_ratio, mean_ratio(x, tet));
    q.smallest_angle = std::min(q.smallest_angle, angle);
    q.below_5_degrees += angle < 5;
    q.below_10_degrees += angle < 10;
  }
  return q;
}

} // namespace drogue::meshing
