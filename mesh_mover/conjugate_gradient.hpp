// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>

#include "common/base/result.hpp"
#include "mesh_mover/stiffness.hpp"

namespace drogue::mesh_mover {

/// PETSc and MPI for as long as it lives; one in a process. Signals stay with the program.
class PetscSession {
 public:
  /// Errors (ErrorKind::config): started on more than one rank. @note Collective
  [[nodiscard]] static Result<std::unique_ptr<PetscSession>> start();
  ~PetscSession();
  PetscSession(const PetscSession&) = delete;
  PetscSession& operator=(const PetscSession&) = delete;

 private:
  PetscSession() = default;
};

struct SolveOutcome {
  bool converged = false;
  int iterations = 0;
  /// Euclidean norm of the residual at the end.
  double residual = 0;
};

/// PETSc's conjugate gradients on 3 x 3 blocks, preconditioned with block ILU(0), which is symmetric for a
/// symmetric matrix; where that is not positive definite, with the inverse diagonal blocks until the next
/// update().
class ConjugateGradient {
 public:
  ConjugateGradient();
  ~ConjugateGradient();
  ConjugateGradient(const ConjugateGradient&) = delete;
  ConjugateGradient& operator=(const ConjugateGradient&) = delete;

  /// Makes room for a matrix. Errors (ErrorKind::internal): PETSc fails. @pre a PetscSession lives
  [[nodiscard]] Result<void> create(const BlockPattern& pattern);
  /// The blocks of the matrix, to be filled before update(): {blocks, 3, 3}, each block column-major.
  [[nodiscard]] std::span<double> values();
  /// The matrix has new values: factors the preconditioner.
  [[nodiscard]] Result<void> update();
  /// Solves A x = b from the start value in x until the residual's Euclidean norm is at most `tolerance`.
  /// `b` and `x` {3 rows}.
  [[nodiscard]] Result<SolveOutcome> solve(std::span<const double> b, std::span<double> x, double tolerance,
                                           int max_iterations);
  /// Whether a solve since the last update() had to leave the block ILU.
  [[nodiscard]] bool fell_back() const;
  /// y = A x.
  [[nodiscard]] Result<void> multiply(std::span<const double> x, std::span<double> y);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

} // namespace drogue::mesh_mover
