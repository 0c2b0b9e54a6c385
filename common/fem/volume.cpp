// SPDX-License-Identifier: GPL-3.0-or-later
//
// Shape functions and quadrature of volume elements.
#include <cassert>
#include <cmath>

#include "common/fem/quadrature.hpp"
#include "common/fem/shape.hpp"

namespace drogue::fem {
namespace {

using Point = std::array<double, 3>;

/// Nodes of the hexahedron in Gmsh's order: corners, middles of the edges, of the faces, of the whole.
constexpr int hex27_nodes[27][3] = {
    {-1, -1, -1}, {1, -1, -1}, {1, 1, -1},  {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1},
    {-1, 1, 1},   {0, -1, -1}, {-1, 0, -1}, {-1, -1, 0}, {1, 0, -1},  {1, -1, 0}, {0, 1, -1},
    {1, 1, 0},    {-1, 1, 0},  {0, -1, 1},  {-1, 0, 1},  {1, 0, 1},   {0, 1, 1},  {0, 0, -1},
    {0, -1, 0},   {-1, 0, 0},  {1, 0, 0},   {0, 1, 0},   {0, 0, 1},   {0, 0, 0}};

/// Ends of the tetrahedron's edges in the order of their middle nodes.
constexpr std::size_t tet10_edges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {3, 0}, {2, 3}, {1, 3}};

/// Gradients of the barycentric coordinates.
constexpr double barycentric_gradient[4][3] = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

struct Polynomial {
  double value, derivative;
};
/// Quadratic Lagrange polynomial on {-1, 0, 1} that is one at node i.
Polynomial quadratic(int i, double s) noexcept {
  if (i < 0) return {0.5 * s * (s - 1), s - 0.5};
  if (i > 0) return {0.5 * s * (s + 1), s + 0.5};
  return {1 - s * s, -2 * s};
}

void fill_hex27(VolumeShape& s, const Point& xi) noexcept {
  for (std::size_t a = 0; a < 27; ++a) {
    Polynomial p[3];
    for (std::size_t k = 0; k < 3; ++k) p[k] = quadratic(hex27_nodes[a][k], xi[k]);
    s.N[a] = p[0].value * p[1].value * p[2].value;
    s.dN[0][a] = p[0].derivative * p[1].value * p[2].value;
    s.dN[1][a] = p[0].value * p[1].derivative * p[2].value;
    s.dN[2][a] = p[0].value * p[1].value * p[2].derivative;
  }
}

void fill_tetrahedron(VolumeShape& s, const Point& xi) noexcept {
  const double l[4] = {1 - xi[0] - xi[1] - xi[2], xi[0], xi[1], xi[2]};
  const bool linear = s.nodes == 4;
  for (std::size_t a = 0; a < 4; ++a) {
    s.N[a] = linear ? l[a] : l[a] * (2 * l[a] - 1);
    for (std::size_t k = 0; k < 3; ++k) s.dN[k][a] = (linear ? 1 : 4 * l[a] - 1) * barycentric_gradient[a][k];
  }
  if (linear) return;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [i, j] = tet10_edges[e];
    s.N[4 + e] = 4 * l[i] * l[j];
    for (std::size_t k = 0; k < 3; ++k)
      s.dN[k][4 + e] = 4 * (l[i] * barycentric_gradient[j][k] + l[j] * barycentric_gradient[i][k]);
  }
}

/// Adds the points that permute the barycentric coordinates (a, a, a, 1 - 3 a).
void add_vertex_orbit(std::vector<VolumePoint>& rule, double a, double weight) {
  const double b = 1 - 3 * a;
  for (const Point& p : {Point{a, a, a}, Point{b, a, a}, Point{a, b, a}, Point{a, a, b}})
    rule.push_back({p, weight});
}

/// Adds the points that permute the barycentric coordinates (a, a, 1/2 - a, 1/2 - a).
void add_edge_orbit(std::vector<VolumePoint>& rule, double a, double weight) {
  const double b = 0.5 - a;
  for (const Point& p :
       {Point{a, a, b}, Point{a, b, a}, Point{b, a, a}, Point{a, b, b}, Point{b, a, b}, Point{b, b, a}})
    rule.push_back({p, weight});
}

std::vector<VolumePoint> tetrahedron_rule(int degree) {
  assert(degree <= 5);
  std::vector<VolumePoint> rule;
  if (degree <= 1) {
    rule.push_back({{0.25, 0.25, 0.25}, 1.0 / 6});
  } else if (degree == 2) {
    add_vertex_orbit(rule, (5 - std::sqrt(5.0)) / 20, 1.0 / 24);
  } else { // 14 points: the root of the moment equations up to degree five with positive weights
    add_vertex_orbit(rule, 0.31088591926330060980, 0.018781320953002641800);
    add_vertex_orbit(rule, 0.092735250310891226402, 0.012248840519393658257);
    add_edge_orbit(rule, 0.045503704125649649492, 0.0070910034628469110730);
  }
  return rule;
}

} // namespace

std::array<double, 3> volume_node(ElementKind kind, int a) noexcept {
  assert(a < mesh::nodes_per_element(kind));
  const auto i = static_cast<std::size_t>(a);
  if (kind == ElementKind::hex27) {
    const auto& n = hex27_nodes[i];
    return {static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])};
  }
  constexpr Point corner[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (i < 4) return corner[i];
  const Point &p = corner[tet10_edges[i - 4][0]], &q = corner[tet10_edges[i - 4][1]];
  return {0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1]), 0.5 * (p[2] + q[2])};
}

VolumeShape volume_shape(ElementKind kind, const std::array<double, 3>& xi) noexcept {
  assert(mesh::dimension(kind) == 3);
  VolumeShape s;
  s.nodes = mesh::nodes_per_element(kind);
  if (kind == ElementKind::hex27)
    fill_hex27(s, xi);
  else
    fill_tetrahedron(s, xi);
  return s;
}

std::vector<VolumePoint> volume_quadrature(ElementKind kind, int degree) {
  assert(degree >= 1 && degree <= 20);
  if (kind != ElementKind::hex27) return tetrahedron_rule(degree);
  const GaussRule g = gauss_legendre(degree / 2 + 1);
  std::vector<VolumePoint> rule;
  for (std::size_t i = 0; i < g.points.size(); ++i)
    for (std::size_t j = 0; j < g.points.size(); ++j)
      for (std::size_t k = 0; k < g.points.size(); ++k)
        rule.push_back({{g.points[i], g.points[j], g.points[k]}, g.weights[i] * g.weights[j] * g.weights[k]});
  return rule;
}

} // namespace drogue::fem
