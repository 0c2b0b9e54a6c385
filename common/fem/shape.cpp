// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/shape.hpp"

#include <cassert>
#include <tuple>
#include <utility>

namespace drogue::fem {
namespace {

/// Quadratic Lagrange polynomial on {-1, 0, 1} that is one at node i, and its derivative.
std::pair<double, double> quadratic(int i, double s) noexcept {
  if (i < 0) return {0.5 * s * (s - 1), s - 0.5};
  if (i > 0) return {0.5 * s * (s + 1), s + 0.5};
  return {1 - s * s, -2 * s};
}

constexpr int xi_of_quad9[9] = {-1, 1, 1, -1, 0, 1, 0, -1, 0};
constexpr int eta_of_quad9[9] = {-1, -1, 1, 1, -1, 0, 1, 0, 0};

void set(SurfaceShape& s, int a, double N, double dN_dxi, double dN_deta) noexcept {
  const auto i = static_cast<std::size_t>(a);
  s.N[i] = N;
  s.dN_dxi[i] = dN_dxi;
  s.dN_deta[i] = dN_deta;
}

} // namespace

bool is_quadrilateral(ElementKind kind) noexcept {
  return kind == ElementKind::quad4 || kind == ElementKind::quad9;
}

std::array<double, 2> parent_centre(ElementKind kind) noexcept {
  return is_quadrilateral(kind) ? std::array{0.0, 0.0} : std::array{1.0 / 3, 1.0 / 3};
}

SurfaceShape surface_shape(ElementKind kind, double xi, double eta) noexcept {
  assert(mesh::dimension(kind) == 2);
  SurfaceShape s;
  s.nodes = mesh::nodes_per_element(kind);
  const double zeta = 1 - xi - eta;
  switch (kind) {
  case ElementKind::tri3:
    set(s, 0, zeta, -1, -1);
    set(s, 1, xi, 1, 0);
    set(s, 2, eta, 0, 1);
    break;
  case ElementKind::tri6:
    set(s, 0, zeta * (2 * zeta - 1), 1 - 4 * zeta, 1 - 4 * zeta);
    set(s, 1, xi * (2 * xi - 1), 4 * xi - 1, 0);
    set(s, 2, eta * (2 * eta - 1), 0, 4 * eta - 1);
    set(s, 3, 4 * zeta * xi, 4 * (zeta - xi), -4 * xi);
    set(s, 4, 4 * xi * eta, 4 * eta, 4 * xi);
    set(s, 5, 4 * eta * zeta, -4 * eta, 4 * (zeta - eta));
    break;
  case ElementKind::quad4:
    for (int a = 0; a < 4; ++a) {
      const double p = xi_of_quad9[a], q = eta_of_quad9[a];
      set(s, a, 0.25 * (1 + p * xi) * (1 + q * eta), 0.25 * p * (1 + q * eta), 0.25 * q * (1 + p * xi));
    }
    break;
  case ElementKind::quad9:
    for (int a = 0; a < 9; ++a) {
      const auto [f, df] = quadratic(xi_of_quad9[a], xi);
      const auto [g, dg] = quadratic(eta_of_quad9[a], eta);
      set(s, a, f * g, df * g, f * dg);
    }
    break;
  case ElementKind::point1:
  case ElementKind::line2:
  case ElementKind::line3:
  case ElementKind::tet4:
  case ElementKind::tet10:
  case ElementKind::hex27:
    break;
  }
  return s;
}

LineShape line_shape(ElementKind kind, double xi) noexcept {
  assert(mesh::dimension(kind) == 1);
  if (kind == ElementKind::line2) return {2, {0.5 * (1 - xi), 0.5 * (1 + xi)}, {-0.5, 0.5}};
  constexpr int node[3] = {-1, 1, 0};
  LineShape s{3, {}, {}};
  for (std::size_t a = 0; a < 3; ++a) std::tie(s.N[a], s.dN_dxi[a]) = quadratic(node[a], xi);
  return s;
}

} // namespace drogue::fem
