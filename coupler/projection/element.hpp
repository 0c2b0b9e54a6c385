// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/fem/quadrature.hpp"
#include "common/fem/shape.hpp"
#include "common/mesh/mesh.hpp"

namespace drogue::projection {

/// Shape functions of an element of the interface. A line is a strip of width one across its plane z = const:
///   x(xi, eta) = sum_a N_a(xi) X_a + eta e_z,
/// so that its length is an area per unit depth, and x_xi cross x_eta lies to the right of its direction.
struct ElementShape : fem::SurfaceShape {
  double width = 0; ///< 1 on lines, 0 on triangles and quadrilaterals
};
/// @pre dimension(kind) is 1 (then eta is not used) or 2
[[nodiscard]] ElementShape element_shape(mesh::ElementKind kind, double xi, double eta) noexcept;

/// As fem::surface_quadrature, and the Gauss rule on lines, whose weights add up to 2.
[[nodiscard]] std::vector<fem::SurfacePoint> element_quadrature(mesh::ElementKind kind, int degree);
/// That rule on each of n^2 equal parts of the parent domain (n on lines).
[[nodiscard]] std::vector<fem::SurfacePoint> composite_quadrature(mesh::ElementKind kind, int degree, int n);

[[nodiscard]] std::array<double, 2> parent_centre(mesh::ElementKind kind) noexcept;

/// Coordinates of an element's nodes, one a column; columns beyond `nodes` are zero.
using NodeMatrix = Eigen::Matrix<double, 3, fem::max_surface_nodes>;
[[nodiscard]] NodeMatrix gather(std::span<const std::int32_t> nodes,
                                std::span<const double> coordinates) noexcept;

/// Position, tangents and area vector x_xi cross x_eta at one point of an element.
[[nodiscard]] inline Eigen::Vector3d combine(const std::array<double, fem::max_surface_nodes>& N, int nodes,
                                             const NodeMatrix& X) noexcept {
  Eigen::Vector3d x = N[0] * X.col(0);
  for (int a = 1; a < nodes; ++a) x += N[static_cast<std::size_t>(a)] * X.col(a);
  return x;
}
[[nodiscard]] inline Eigen::Vector3d area_vector(const ElementShape& s, const NodeMatrix& X) noexcept {
  Eigen::Vector3d across = combine(s.dN_deta, s.nodes, X);
  across[2] += s.width;
  return combine(s.dN_dxi, s.nodes, X).cross(across);
}

/// Linear triangles and lines: area and normal are constant, whatever their shape.
[[nodiscard]] inline bool is_flat(mesh::ElementKind kind) noexcept {
  return kind == mesh::ElementKind::tri3 || kind == mesh::ElementKind::line2;
}
/// int N_b N_c over the parent domain of a flat element; on lines the last row and column are zero.
[[nodiscard]] const Eigen::Matrix3d& flat_mass(mesh::ElementKind kind) noexcept;

/// Area of the parent domain times the Jacobian at the centre.
[[nodiscard]] double rough_area(mesh::ElementKind kind, const NodeMatrix& X) noexcept;
/// Longest distance of two corners along an edge.
[[nodiscard]] double longest_edge(mesh::ElementKind kind, const NodeMatrix& X) noexcept;
/// Distance of the nodes of an element, about.
[[nodiscard]] double node_spacing(mesh::ElementKind kind, const NodeMatrix& X) noexcept;

} // namespace drogue::projection
