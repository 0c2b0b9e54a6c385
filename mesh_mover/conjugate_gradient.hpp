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
///
/// On several ranks each works on its own rows; the coarse matrix is factored by all of them.
class ConjugateGradient {
 public:
  /// `A` and `given` must outlive this object; A's values may change between calls of update().
  /// @param threads 0: those to use by default, fewer for small matrices
  ConjugateGradient(const SymmetricBlocks<double>& A, const Mask& given, int threads = 0)
      : ConjugateGradient(A, given, SharedRows(A), threads) {}
  /// On several ranks, of A those values suffice that the own rows and columns need.
  ConjugateGradient(const SymmetricBlocks<double>& A, const Mask& given, SharedRows rows, int threads = 0);
  ConjugateGradient(const ConjugateGradient&) = delete;
  ConjugateGradient& operator=(const ConjugateGradient&) = delete;

  /// The matrix has new values, for nodes at `positions` {3 rows}: factors the preconditioner. @note
  /// Collective
  [[nodiscard]] Result<void> update(std::span<const double> positions);
  /// Solves A x = b from the start value in x, corrected on the coarse space first, until the residual's
  /// Euclidean norm is at most `tolerance`. `b` and `x` {3 rows}, whole on every rank. @note Collective
  [[nodiscard]] Result<SolveOutcome> solve(std::span<const double> b, std::span<double> x, double tolerance,
                                           int max_iterations);

 private:
  using Vector = Eigen::VectorXd;
  [[nodiscard]] Result<void> precondition(const Vector& r, Vector& z);

  [[nodiscard]] double dot(const Vector& a, const Vector& b);
  /// function(range) for the entries of each part, at the same time.
  template <class Function>
  void for_each_part(Function&& function);

  SharedRows rows_;
  RowParts parts_;
  PartedProduct A_;
  IncompleteCholesky incomplete_;
  CoarseSpace coarse_;
  Vector r_, z_, p_, w_;
  std::vector<double> sums_; // of the parts
};

} // namespace drogue::mesh_mover
