// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

/// The fluid mesh as a linearly elastic solid without mass, on four-node tetrahedra or, in two dimensions, on
/// three-node triangles [stein2001, "Mesh-Moving Strategy"; tezduyar1992; stein2003].
///
/// Strong form: find the mesh displacement u with
///     div sigma(u) = 0,   sigma = lambda tr(eps) I + 2 mu eps,   eps = (grad u + grad u^T) / 2,
/// u given on the moving boundaries; on sliding planes only its normal component is given.
///
/// Weak form: for every w that vanishes where u is given,
///     sum_e  k_e  integral_e  eps(w) : sigma(u)  (J0 / J_e)^chi  dx = 0.
/// J_e is the Jacobian of the element's map, J0 a constant of the mesh that scales out, k_e = 1 except in
/// stiffer layers near a surface. chi = 0 is plain elasticity; chi = 1 drops the Jacobian from the integral,
/// so that small elements are stiffer and keep their shape.
///
/// With chi = 0 every affine displacement of the boundary is reproduced; with chi > 0 on elements of
/// different size only those without strain are (translations and infinitesimal rotations).
namespace drogue::mesh_mover {

/// Elastic constants; Young's modulus is one, as only ratios matter. In two dimensions: plane strain.
struct PseudoSolid {
  double lambda = 0;
  double mu = 0;
  /// chi, exponent of the stiffening.
  double stiffening_exponent = 1;
  /// J0, the mean Jacobian of the initial elements [length^dimension].
  double reference_jacobian = 1;
};

/// @pre 0 <= poisson_ratio < 1/2
[[nodiscard]] inline PseudoSolid pseudo_solid(double poisson_ratio, double stiffening_exponent,
                                              double reference_jacobian) noexcept {
  return {.lambda = poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio)),
          .mu = 1 / (2 * (1 + poisson_ratio)),
          .stiffening_exponent = stiffening_exponent,
          .reference_jacobian = reference_jacobian};
}

/// A simplex of dimension D: its D + 1 linear shape functions.
template <int D>
struct SimplexGeometry {
  /// Column a: gradient of the shape function N_a [1/length].
  Eigen::Matrix<double, D, D + 1> gradients;
  /// Jacobian of the map from the unit simplex: D! times the signed volume [length^D].
  double jacobian = 0;
};

/// Columns: the edges from node 0. `points` {n, 3}, `nodes` {D + 1}.
template <int D>
[[nodiscard]] Eigen::Matrix<double, D, D> simplex_edges(std::span<const double> points,
                                                        std::span<const std::int32_t> nodes) noexcept {
  using Vector = Eigen::Matrix<double, D, 1>;
  const auto point = [&](int a) {
    return Eigen::Map<const Vector>(points.data() +
                                    3 * static_cast<std::size_t>(nodes[static_cast<std::size_t>(a)]));
  };
  Eigen::Matrix<double, D, D> edges;
  for (int a = 0; a < D; ++a) edges.col(a) = point(a + 1) - point(0);
  return edges;
}

/// Signed: D! times the volume. `points` {n, 3}, `nodes` {D + 1}.
template <int D>
[[nodiscard]] double simplex_jacobian(std::span<const double> points,
                                      std::span<const std::int32_t> nodes) noexcept {
  return simplex_edges<D>(points, nodes).determinant();
}

/// @pre the element is not degenerate
template <int D>
[[nodiscard]] SimplexGeometry<D> simplex_geometry(std::span<const double> points,
                                                  std::span<const std::int32_t> nodes) noexcept {
  const auto edges = simplex_edges<D>(points, nodes);
  SimplexGeometry<D> element;
  element.jacobian = edges.determinant();
  element.gradients.template rightCols<D>() = edges.inverse().transpose();
  element.gradients.col(0) = -element.gradients.template rightCols<D>().rowwise().sum();
  return element;
}

/// The element's factor: volume times (J0 / J)^chi. @pre jacobian > 0
template <int D>
[[nodiscard]] double stiffness_weight(const PseudoSolid& solid, double jacobian) noexcept {
  const double volume = jacobian / (D == 2 ? 2 : 6);
  if (solid.stiffening_exponent == 0) return volume;
  return volume * std::pow(solid.reference_jacobian / jacobian, solid.stiffening_exponent);
}

/// Block of the element matrix between nodes a and b, for the weight of stiffness_weight():
///     (K_ab)_ij = weight (lambda g_a,i g_b,j + mu g_a,j g_b,i + mu delta_ij g_a . g_b).
template <int D>
[[nodiscard]] Eigen::Matrix<double, D, D> stiffness_block(const PseudoSolid& solid,
                                                          const SimplexGeometry<D>& element, double weight,
                                                          int a, int b) noexcept {
  const Eigen::Matrix<double, D, 1> g_a = element.gradients.col(a);
  const Eigen::Matrix<double, D, 1> g_b = element.gradients.col(b);
  const double lambda = weight * solid.lambda;
  const double mu = weight * solid.mu;
  Eigen::Matrix<double, D, D> K = lambda * g_a * g_b.transpose() + mu * g_b * g_a.transpose();
  K.diagonal().array() += mu * g_a.dot(g_b);
  return K;
}

} // namespace drogue::mesh_mover
