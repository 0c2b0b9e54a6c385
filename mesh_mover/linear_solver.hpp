// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "mesh_mover/conjugate_gradient.hpp"
#include "mesh_mover/direct_solver.hpp"
#include "mesh_mover/settings.hpp"

namespace drogue::mesh_mover {

/// Whether a mesh of so many nodes is solved by direct factors.
[[nodiscard]] bool is_direct(LinearSolverKind kind, std::size_t nodes, int dimension);

/// The one place where systems of the pseudo-solid are solved: by direct factors or by iteration.
class LinearSolver {
 public:
  /// `A` and `given` must outlive this object.
  /// @param kind LinearSolverKind::automatic: direct in two dimensions, and for small meshes in three
  LinearSolver(const SymmetricBlocks<double>& A, const Mask& given, int dimension, LinearSolverKind kind)
      : LinearSolver(A, given, dimension, kind, SharedRows(A)) {}
  /// @param rows shared among ranks only for an iteration
  LinearSolver(const SymmetricBlocks<double>& A, const Mask& given, int dimension, LinearSolverKind kind,
               SharedRows rows);

  [[nodiscard]] bool is_direct() const { return direct_ != nullptr; }
  /// The matrix has new values, for nodes at `positions` {3 rows}.
  [[nodiscard]] Result<void> update(std::span<const double> positions);
  /// Solves A x = b; an iteration starts from x and ends when the residual's Euclidean norm is at most
  /// `tolerance`. `b` and `x` {3 rows}.
  [[nodiscard]] Result<SolveOutcome> solve(std::span<const double> b, std::span<double> x, double tolerance,
                                           int max_iterations);

 private:
  std::unique_ptr<DirectSolver> direct_; // one of the two
  std::unique_ptr<ConjugateGradient> iterative_;
};

} // namespace drogue::mesh_mover
