// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

/// The fluid mesh as a linearly elastic solid without mass, on four-node tetrahedra
/// [stein2001, "Mesh-Moving Strategy"; tezduyar1992; stein2003].
///
/// Strong form: find the mesh displacement u with
///     div sigma(u) = 0,   sigma = lambda tr(eps) I + 2 mu eps,   eps = (grad u + grad u^T) / 2,
/// u given on the moving boundaries; on sliding planes only its normal component is given.
///
/// Weak form: for every w that vanishes where u is given,
///     sum_e  integral_e  eps(w) : sigma(u)  (J0 / J_e)^chi  dx = 0.
/// J_e is the Jacobian of the element's map, J0 a constant of the mesh that scales out. chi = 0 is plain
/// elasticity; chi = 1 drops the Jacobian from the integral, so that small elements are stiffer and keep
/// their shape.
///
/// With chi = 0 every affine displacement of the boundary is reproduced; with chi > 0 on elements of
/// different size only those without strain are (translations and infinitesimal rotations).
namespace drogue::mesh_mover {

/// Elastic constants; Young's modulus is one, as only ratios matter.
struct PseudoSolid {
  double lambda = 0;
  double mu = 0;
  /// chi, exponent of the stiffening.
  double stiffening_exponent = 1;
  /// J0, six times the mean volume of the initial elements [length^3].
  double reference_jacobian = 1;
};

/// @pre 0 <= poisson_ratio < 1/2
[[nodiscard]] PseudoSolid pseudo_solid(double poisson_ratio, double stiffening_exponent,
                                       double reference_jacobian) noexcept;

struct TetGeometry {
  /// Column a: gradient of the shape function N_a [1/length].
  Eigen::Matrix<double, 3, 4> gradients;
  /// Six times the signed volume [length^3].
  double jacobian = 0;
};

/// Signed six-fold volume of a tetrahedron. `points` {n, 3}, `nodes` {4}.
[[nodiscard]] double tet_jacobian(std::span<const double> points,
                                  std::span<const std::int32_t> nodes) noexcept;

/// @pre the element is not degenerate
[[nodiscard]] TetGeometry tet_geometry(std::span<const double> points,
                                       std::span<const std::int32_t> nodes) noexcept;

/// The element's factor: volume times (J0 / J)^chi. @pre jacobian > 0
[[nodiscard]] double stiffness_weight(const PseudoSolid& solid, double jacobian) noexcept;

/// Block of the element matrix between nodes a and b, for the weight of stiffness_weight():
///     (K_ab)_ij = weight (lambda g_a,i g_b,j + mu g_a,j g_b,i + mu delta_ij g_a . g_b).
[[nodiscard]] inline Eigen::Matrix3d stiffness_block(const PseudoSolid& solid, const TetGeometry& element,
                                                     double weight, int a, int b) noexcept {
  const Eigen::Vector3d g_a = element.gradients.col(a);
  const Eigen::Vector3d g_b = element.gradients.col(b);
  const double lambda = weight * solid.lambda;
  const double mu = weight * solid.mu;
  Eigen::Matrix3d K = lambda * g_a * g_b.transpose() + mu * g_b * g_a.transpose();
  K.diagonal().array() += mu * g_a.dot(g_b);
  return K;
}

} // namespace drogue::mesh_mover
