// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/SparseCore>

#include "coupler/projection/surface.hpp"

namespace drogue::projection {

/// M_ab = int N_a N_b dA over one element, and its area.
struct ElementMass {
  Eigen::Matrix<double, fem::max_surface_nodes, fem::max_surface_nodes> M;
  double area = 0;
};
/// Quadrature of degree 4 (in each direction on quadrilaterals): exact on flat elements with straight edges.
[[nodiscard]] ElementMass element_mass(mesh::ElementKind kind, const NodeMatrix& X);

/// Norm and mean of nodal fields over a surface's reference area.
class SurfaceIntegrals {
 public:
  /// @pre complete() accepted the surface
  explicit SurfaceIntegrals(const Surface& surface);

  [[nodiscard]] double area() const { return area_; }
  /// sqrt(1/A int |v|^2 dA), v of shape {n, components}: a length when v is one. No heap.
  [[nodiscard]] double norm(std::span<const double> v, int components) const noexcept;
  /// 1/A int v dA into {components}. No heap.
  void mean(std::span<const double> v, int components, std::span<double> result) const noexcept;
  /// {n}: positive, adding up to the area: the diagonal of the mass matrix, scaled [hinton1976]. For the
  /// weights of an accelerator.
  [[nodiscard]] const std::vector<double>& lumped_area() const { return lumped_; }

 private:
  double area_ = 0;
  Eigen::SparseMatrix<double, Eigen::RowMajor, int> M_; ///< diagonal, and twice what lies below it
  std::vector<double> integral_;                        ///< {n}: int N_a dA
  std::vector<double> lumped_;
};

/// int n dA over the surface with its nodes at `x`, {n, 3}: what a uniform pressure of 1 pulls with. Its
/// component along a direction is the area projected along it; zero for a closed surface [area].
[[nodiscard]] Eigen::Vector3d vector_area(const Surface& surface, std::span<const double> x);

} // namespace drogue::projection
