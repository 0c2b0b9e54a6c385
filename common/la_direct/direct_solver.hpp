// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include <Eigen/SparseCore>

#include "common/base/result.hpp"

namespace drogue::la {

/// Compressed sparse columns, both triangles stored.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

/// Keeps OpenBLAS to one thread for the whole process: where factors are small its threads only wait for one
/// another, spinning.
void use_one_blas_thread();

/// CHOLMOD's L L^T of a symmetric positive definite matrix. The symbolic analysis is done once for a pattern
/// and reused, with Use::many_factors.
class CholeskySolver {
 public:
  enum class Use {
    many_factors,   ///< supernodal, METIS ordering: the quickest factorisation
    many_solutions, ///< AMD ordering, L by columns without zeros: quick to analyse, four or eight
                    ///< right-hand sides at a time
  };
  explicit CholeskySolver(Use use = Use::many_factors);
  ~CholeskySolver();
  CholeskySolver(CholeskySolver&&) noexcept;
  CholeskySolver& operator=(CholeskySolver&&) noexcept;

  /// Factors A (its upper triangle is read). Returns false when A is not positive definite.
  /// The first call, and every call after `forget_pattern`, analyses the pattern.
  [[nodiscard]] Result<bool> factor(const SparseMatrix& A);
  void forget_pattern();
  /// Solves A x = b for `columns` right-hand sides, each contiguous; b and x may be the same memory.
  /// @pre the last factor() returned true
  [[nodiscard]] Result<void> solve(std::span<const double> b, std::span<double> x, int columns = 1);

  /// The same without copies, after Use::many_solutions: the equation that each row of L stands for, {n}, ...
  [[nodiscard]] std::span<const int> order() const;
  /// ... and y = (L L^T)^-1 y in place, y {n, lanes} with the right-hand sides side by side and rows in
  /// order().
  /// @param lanes 4 or 8
  void solve_rows(std::span<double> y, int lanes) noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// UMFPACK's L U of a general square matrix, METIS ordering.
class LuSolver {
 public:
  enum class Refinement {
    iterative, ///< until the residual stops falling
    none,      ///< a fifth of the time: for matrices that only approximate, as in Newton's method
  };
  explicit LuSolver(Refinement refinement = Refinement::iterative);
  ~LuSolver();
  LuSolver(LuSolver&&) noexcept;
  LuSolver& operator=(LuSolver&&) noexcept;

  /// Returns false when A is singular.
  [[nodiscard]] Result<bool> factor(const SparseMatrix& A);
  void forget_pattern();
  [[nodiscard]] Result<void> solve(std::span<const double> b, std::span<double> x);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

} // namespace drogue::la
