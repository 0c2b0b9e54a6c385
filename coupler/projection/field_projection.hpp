// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include <Eigen/SparseCore>

#include "common/base/cache_lines.hpp"
#include "common/la_direct/direct_solver.hpp"
#include "coupler/projection/interface_quadrature.hpp"

namespace drogue::projection {

/// Least-squares projection of displacement and velocity, structure -> fluid [stein2001, eq. 4]:
///   find d_f:  int_F N_a ( sum_b N_b d_f,b - d_s(pi(X)) ) dA = 0  for all a,    M_f d_f = B d_s,
/// over the fluid's reference area, pi the closest point in material coordinates. M_f and B use the same
/// integrals of N_a, so the rows of B add up to those of M_f and constants come through to rounding.
///
/// Fluid nodes with the same material coordinates (the two sides of a canopy) share one unknown: the sides
/// cannot part. When the two surfaces have the same elements on the same material nodes, values are copied.
///
/// Cost of one component: 2 nnz(B) + 4 nnz(L) flops; L is CHOLMOD's factor of M_f.
class FieldProjection {
 public:
  /// Finds the unknowns, and where all of the fluid's elements are flat factors M_f.
  /// Errors (ErrorKind::internal): CHOLMOD; (ErrorKind::config): M_f is singular.
  [[nodiscard]] static Result<FieldProjection> begin(const Surface& structure, const Surface& fluid);
  /// Makes B, and M_f where it is still to be made. Errors as begin().
  [[nodiscard]] Result<void> end(const InterfaceQuadrature& quadrature, const Surface& structure,
                                 const Surface& fluid);

  /// From `structure` {structure nodes, components} to `fluid` {fluid nodes, components}.
  struct Transfer {
    std::span<const double> structure;
    std::span<double> fluid;
  };
  /// Several fields at once: B and the factor, which are larger than they are, are read once for two of them.
  /// @pre components <= 3
  [[nodiscard]] Result<void> apply(std::span<const Transfer> fields, int components = 3);
  [[nodiscard]] Result<void> apply(std::span<const double> structure, std::span<double> fluid,
                                   int components = 3) {
    const Transfer one{structure, fluid};
    return apply(std::span(&one, 1), components);
  }

  [[nodiscard]] bool matching() const { return !copy_from_.empty(); }

 private:
  void copy(const Transfer& field, std::size_t components) const;
  void project(std::span<const Transfer> fields, std::size_t components);
  [[nodiscard]] Result<void> factor_mass(const Surface& fluid, const InterfaceQuadrature* quadrature);

  std::size_t structure_nodes_ = 0;
  std::vector<std::int32_t> copy_from_; ///< {fluid nodes}: structure node; empty unless matching
  bool is_factored_ = false;
  std::int32_t unknowns_ = 0;
  std::vector<std::int32_t> unknown_; ///< {fluid nodes}: row of the factor of M_f, and of B
  Eigen::SparseMatrix<double, Eigen::RowMajor, int> B_;
  la::CholeskySolver M_{la::CholeskySolver::Use::many_solutions};
  CacheLines<double> source_, solution_; ///< {structure nodes or unknowns, four values a field}
};

} // namespace drogue::projection
