// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh_mover/coarse_space.hpp"
#include "mesh_mover/incomplete_cholesky.hpp"

namespace drogue::mesh_mover {

struct SolveOutcome {
  bool converged = false;
  int iterations = 0;
  /// Euclidean norm of the residual at the end.
  double residual = 0;
};

/// Conjugate gradients with the additive two-level preconditioner
///     M^-1 = (L D L^T)^-1 + Z E^-1 Z^T
/// of incomplete factors, which smooth between neighbours, and a coarse space, which carries the motion of
/// the boundary through the whole mesh, so that the number of iterations hardly grows with the mesh.
class ConjugateGradient {
 public:
  /// `A` and `given` must outlive this object; A's values may change between calls of update().
  ConjugateGradient(const SymmetricBlocks<double>& A, const Mask& given);

  /// The matrix has new values: factors the preconditioner.
  [[nodiscard]] Result<void> update();
  /// Solves A x = b from the start value in x, corrected on the coarse space first, until the residual's
  /// Euclidean norm is at most `tolerance`. `b` and `x` {3 rows}.
  [[nodiscard]] Result<SolveOutcome> solve(std::span<const double> b, std::span<double> x, double tolerance,
                                           int max_iterations);

 private:
  using Vector = Eigen::VectorXd;
  [[nodiscard]] Result<void> precondition(const Vector& r, Vector& z);

  const SymmetricBlocks<double>& A_;
  IncompleteCholesky incomplete_;
  CoarseSpace coarse_;
  Vector r_, z_, p_, w_;
};

} // namespace drogue::mesh_mover
