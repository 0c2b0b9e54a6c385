// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cassert>

#include <Eigen/Core>

#include "common/fem/quadrature.hpp"
#include "common/fem/shape.hpp"

namespace drogue::structure {

/// Nodes and quadrature points of the surface elements: one point on triangles, 3 x 3 on nine-node
/// quadrilaterals.
template <mesh::ElementKind Kind>
struct SurfaceTraits;
template <>
struct SurfaceTraits<mesh::ElementKind::tri3> {
  static constexpr int nodes = 3, points = 1, degree = 1;
};
template <>
struct SurfaceTraits<mesh::ElementKind::quad9> {
  static constexpr int nodes = 9, points = 9, degree = 5;
};

/// Shape functions at the quadrature points of a surface element, as fixed-size matrices.
template <mesh::ElementKind Kind>
struct SurfaceRule {
  using Traits = SurfaceTraits<Kind>;
  struct Point {
    Eigen::Matrix<double, Traits::nodes, 1> N;
    /// Columns: dN/dxi, dN/deta.
    Eigen::Matrix<double, Traits::nodes, 2> dN;
    double weight;
  };
  std::array<Point, Traits::points> points;

  SurfaceRule() {
    const auto rule = fem::surface_quadrature(Kind, Traits::degree);
    assert(rule.size() == points.size());
    for (std::size_t q = 0; q < points.size(); ++q) {
      const fem::SurfaceShape shape = fem::surface_shape(Kind, rule[q].xi, rule[q].eta);
      points[q].weight = rule[q].weight;
      for (int a = 0; a < Traits::nodes; ++a) {
        const auto i = static_cast<std::size_t>(a);
        points[q].N(a) = shape.N[i];
        points[q].dN(a, 0) = shape.dN_dxi[i];
        points[q].dN(a, 1) = shape.dN_deta[i];
      }
    }
  }
};

/// The rule of a kind, built once. Fetch it outside element loops.
template <mesh::ElementKind Kind>
[[nodiscard]] const SurfaceRule<Kind>& surface_rule() {
  static const SurfaceRule<Kind> rule;
  return rule;
}

} // namespace drogue::structure
