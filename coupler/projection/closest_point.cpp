// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/closest_point.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace drogue::projection {
namespace {

using mesh::ElementKind;

constexpr int max_iterations = 30;
constexpr double inside_tolerance = 1e-12;
constexpr double step_tolerance = 1e-13;

using Parent = std::array<double, 2>;
constexpr Parent triangle_nodes[] = {{0, 0}, {1, 0}, {0, 1}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}};
constexpr Parent quad_nodes[] = {{-1, -1}, {1, -1}, {1, 1},  {-1, 1}, {0, -1},
                                 {1, 0},   {0, 1},  {-1, 0}, {0, 0}};

constexpr Parent line_nodes[] = {{-1, 0}, {1, 0}, {0, 0}};

const Parent* parent_nodes(ElementKind kind) {
  if (mesh::dimension(kind) == 1) return line_nodes;
  return fem::is_quadrilateral(kind) ? quad_nodes : triangle_nodes;
}

bool is_inside(ElementKind kind, const Parent& s) {
  constexpr double t = inside_tolerance;
  if (fem::is_quadrilateral(kind)) return std::abs(s[0]) <= 1 + t && std::abs(s[1]) <= 1 + t;
  return s[0] >= -t && s[1] >= -t && s[0] + s[1] <= 1 + t;
}

double distance2(ElementKind kind, const NodeMatrix& X, const Eigen::Vector3d& p, const Parent& s) {
  const auto shape = element_shape(kind, s[0], s[1]);
  return (combine(shape.N, shape.nodes, X) - p).squaredNorm();
}

Parent start(ElementKind kind, const NodeMatrix& X, const Eigen::Vector3d& p) {
  int nearest = 0;
  for (int a = 1; a < mesh::nodes_per_element(kind); ++a)
    if ((X.col(a) - p).squaredNorm() < (X.col(nearest) - p).squaredNorm()) nearest = a;
  return parent_nodes(kind)[nearest];
}

/// Foot of the perpendicular, wherever it lies; false when the iteration leaves the neighbourhood of the
/// element.
bool find_foot(ElementKind kind, const NodeMatrix& X, const Eigen::Vector3d& p, Parent& s) {
  s = start(kind, X, p);
  for (int k = 0; k < max_iterations; ++k) {
    const auto shape = element_shape(kind, s[0], s[1]);
    const Eigen::Vector3d r = p - combine(shape.N, shape.nodes, X);
    const Eigen::Vector3d g = combine(shape.dN_dxi, shape.nodes, X),
                          h = combine(shape.dN_deta, shape.nodes, X);
    const double gg = g.dot(g), gh = g.dot(h), hh = h.dot(h), det = gg * hh - gh * gh;
    if (!(det > 1e-24 * gg * hh)) return false;
    const double d0 = (hh * g.dot(r) - gh * h.dot(r)) / det, d1 = (gg * h.dot(r) - gh * g.dot(r)) / det;
    s = {s[0] + d0, s[1] + d1};
    if (std::abs(d0) + std::abs(d1) < step_tolerance) return true;
    if (std::abs(s[0]) > 3 || std::abs(s[1]) > 3) return false;
  }
  return is_inside(kind, s);
}

/// Closest point on the edge from a to b (parent coordinates), clamped to its ends; `t` in [0, 1] is the
/// first guess.
Parent on_edge(ElementKind kind, const NodeMatrix& X, const Eigen::Vector3d& p, const Parent& a,
               const Parent& b, double t = 0.5) {
  const Parent d{b[0] - a[0], b[1] - a[1]};
  for (int k = 0; k < max_iterations; ++k) {
    const auto shape = element_shape(kind, a[0] + t * d[0], a[1] + t * d[1]);
    const Eigen::Vector3d r = p - combine(shape.N, shape.nodes, X);
    const Eigen::Vector3d g =
        d[0] * combine(shape.dN_dxi, shape.nodes, X) + d[1] * combine(shape.dN_deta, shape.nodes, X);
    const double gg = g.squaredNorm();
    if (!(gg > 0)) break;
    const double next = std::clamp(t + g.dot(r) / gg, 0.0, 1.0);
    const bool done = std::abs(next - t) < step_tolerance;
    t = next;
    if (done) break;
  }
  return {a[0] + t * d[0], a[1] + t * d[1]};
}

ClosestPoint on_line(ElementKind kind, const NodeMatrix& X, const Eigen::Vector3d& p) {
  const Parent s = on_edge(kind, X, p, line_nodes[0], line_nodes[1], 0.5 * (1 + start(kind, X, p)[0]));
  const auto shape = element_shape(kind, s[0], 0);
  const Eigen::Vector3d r = p - combine(shape.N, shape.nodes, X), g = combine(shape.dN_dxi, shape.nodes, X);
  const bool perpendicular = std::abs(r.dot(g)) <= inside_tolerance * g.squaredNorm();
  return {s[0], 0, r.squaredNorm(), std::abs(s[0]) < 1 || perpendicular};
}

} // namespace

/// Closed form: foot on the plane, else the nearest of the three edges.
ClosestPoint closest_point_of_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                       const Eigen::Vector3d& c, const Eigen::Vector3d& p) noexcept {
  const Eigen::Vector3d g = b - a, h = c - a, r = p - a;
  const double gg = g.dot(g), gh = g.dot(h), hh = h.dot(h), rg = r.dot(g), rh = r.dot(h);
  const double det = gg * hh - gh * gh;
  const auto at = [&](double xi, double eta, bool inside) {
    return ClosestPoint{xi, eta, (r - xi * g - eta * h).squaredNorm(), inside};
  };
  if (det > 1e-24 * gg * hh) {
    const Parent s{(hh * rg - gh * rh) / det, (gg * rh - gh * rg) / det};
    if (is_inside(ElementKind::tri3, s)) return at(s[0], s[1], true);
  }
  const double t = std::clamp((rh - rg + gg - gh) / (gg - 2 * gh + hh), 0.0, 1.0);
  ClosestPoint best = at(std::clamp(rg / gg, 0.0, 1.0), 0, false);
  for (const ClosestPoint& other : {at(1 - t, t, false), at(0, std::clamp(rh / hh, 0.0, 1.0), false)})
    if (other.distance2 < best.distance2) best = other;
  return best;
}

ClosestPoint closest_point(ElementKind kind, const NodeMatrix& X, const Eigen::Vector3d& p) noexcept {
  if (kind == ElementKind::tri3) return closest_point_of_triangle(X.col(0), X.col(1), X.col(2), p);
  if (mesh::dimension(kind) == 1) return on_line(kind, X, p);
  Parent s{};
  if (find_foot(kind, X, p, s) && is_inside(kind, s)) return {s[0], s[1], distance2(kind, X, p, s), true};
  const int corners = fem::is_quadrilateral(kind) ? 4 : 3;
  ClosestPoint best{0, 0, std::numeric_limits<double>::infinity(), false};
  for (int c = 0; c < corners; ++c) {
    const Parent t = on_edge(kind, X, p, parent_nodes(kind)[c], parent_nodes(kind)[(c + 1) % corners]);
    const double d2 = distance2(kind, X, p, t);
    if (d2 < best.distance2) best = {t[0], t[1], d2, false};
  }
  return best;
}

} // namespace drogue::projection
