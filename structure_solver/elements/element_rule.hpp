// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cassert>

#include <Eigen/Core>

#include "common/fem/quadrature.hpp"
#include "common/fem/shape.hpp"

namespace drogue::structure {

/// Nodes, dimension and quadrature of the element kinds. The degrees integrate the St. Venant-Kirchhoff
/// energy and the follower pressure of an affine element exactly; quadrilaterals and hexahedra count the
/// degree in each coordinate.
template <int Nodes, int Dimension, int Points, int Degree>
struct Traits {
  static constexpr int nodes = Nodes, dimension = Dimension, points = Points, degree = Degree;
};
template <mesh::ElementKind Kind>
struct ElementTraits;
template <>
struct ElementTraits<mesh::ElementKind::line2> : Traits<2, 1, 1, 1> {};
template <>
struct ElementTraits<mesh::ElementKind::line3> : Traits<3, 1, 2, 3> {};
template <>
struct ElementTraits<mesh::ElementKind::tri3> : Traits<3, 2, 1, 1> {};
template <>
struct ElementTraits<mesh::ElementKind::tri6> : Traits<6, 2, 6, 4> {};
template <>
struct ElementTraits<mesh::ElementKind::quad4> : Traits<4, 2, 4, 3> {};
template <>
struct ElementTraits<mesh::ElementKind::quad9> : Traits<9, 2, 9, 5> {};
template <>
struct ElementTraits<mesh::ElementKind::tet10> : Traits<10, 3, 14, 4> {};
template <>
struct ElementTraits<mesh::ElementKind::hex27> : Traits<27, 3, 27, 5> {};

/// Shape functions at the quadrature points of an element, as fixed-size matrices.
/// Sums over the nodes are lazy products: Eigen would send the longer ones to its blocked product for large
/// matrices.
template <mesh::ElementKind Kind>
struct ElementRule {
  using Type = ElementTraits<Kind>;
  struct Point {
    Eigen::Matrix<double, Type::nodes, 1> N;
    /// Columns: derivatives with respect to the parent coordinates.
    Eigen::Matrix<double, Type::nodes, Type::dimension> dN;
    double weight;
  };
  std::array<Point, static_cast<std::size_t>(Type::points)> points;

  ElementRule() {
    if constexpr (Type::dimension == 1) {
      const auto rule = fem::gauss_legendre((Type::degree + 1) / 2);
      for (std::size_t q = 0; q < points.size(); ++q) {
        const fem::LineShape s = fem::line_shape(Kind, rule.points[q]);
        set(points[q], rule.weights[q], s.N.data(), {s.dN_dxi.data()});
      }
    } else if constexpr (Type::dimension == 2) {
      const auto rule = fem::surface_quadrature(Kind, Type::degree);
      assert(rule.size() == points.size());
      for (std::size_t q = 0; q < points.size(); ++q) {
        const fem::SurfaceShape s = fem::surface_shape(Kind, rule[q].xi, rule[q].eta);
        set(points[q], rule[q].weight, s.N.data(), {s.dN_dxi.data(), s.dN_deta.data()});
      }
    } else {
      const auto rule = fem::volume_quadrature(Kind, Type::degree);
      assert(rule.size() == points.size());
      for (std::size_t q = 0; q < points.size(); ++q) {
        const fem::VolumeShape s = fem::volume_shape(Kind, rule[q].xi);
        set(points[q], rule[q].weight, s.N.data(), {s.dN[0].data(), s.dN[1].data(), s.dN[2].data()});
      }
    }
  }

 private:
  using Column = Eigen::Map<const Eigen::Matrix<double, Type::nodes, 1>>;
  static void set(Point& point, double weight, const double* N,
                  const std::array<const double*, static_cast<std::size_t>(Type::dimension)>& dN) {
    point.weight = weight;
    point.N = Column(N);
    for (int k = 0; k < Type::dimension; ++k) point.dN.col(k) = Column(dN[static_cast<std::size_t>(k)]);
  }
};

/// The rule of a kind, built once. Fetch it outside element loops.
template <mesh::ElementKind Kind>
[[nodiscard]] const ElementRule<Kind>& element_rule() {
  static const ElementRule<Kind> rule;
  return rule;
}

/// Shares of the nodes in an element's measure (area or volume): positive, and they add up to it.
///
/// Row sums int N_a dV of the consistent mass where these are positive. On six-node triangles and ten-node
/// tetrahedra they are zero or negative at the corners; there the diagonal of the consistent mass, scaled to
/// the total, takes their place [hinton1976]: m_a = V int N_a^2 / sum_b int N_b^2. On affine elements of the
/// other kinds the two are the same.
/// @param measure  dV of each quadrature point: weight times Jacobian
template <mesh::ElementKind Kind>
[[nodiscard]] auto
lumped_measure(const std::array<double, static_cast<std::size_t>(ElementTraits<Kind>::points)>& measure) {
  constexpr bool scaled_diagonal = Kind == mesh::ElementKind::tri6 || Kind == mesh::ElementKind::tet10;
  const auto& rule = element_rule<Kind>();
  Eigen::Matrix<double, ElementTraits<Kind>::nodes, 1> share;
  share.setZero();
  double total = 0;
  for (std::size_t q = 0; q < measure.size(); ++q) {
    const auto& N = rule.points[q].N;
    total += measure[q];
    share += measure[q] * (scaled_diagonal ? N.cwiseAbs2().eval() : N);
  }
  if (scaled_diagonal) share *= total / share.sum();
  return share;
}

} // namespace drogue::structure
