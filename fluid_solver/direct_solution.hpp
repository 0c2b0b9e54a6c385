// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "common/la_direct/direct_solver.hpp"
#include "common/la_krylov/block_matrix.hpp"

namespace drogue::fluid {

/// Solves the block system of a single rank by UMFPACK, held unknowns taken out. The factor is that of the
/// single-precision matrix: good to 1e-7, which Newton's iterations make up for.
template <int n>
class DirectSolution {
 public:
  /// held {rows, n}: unknowns without an equation; their solution is zero.
  DirectSolution(const la::LocalPattern& pattern, std::span<const char> held) {
    const auto at = [](std::int32_t i) { return static_cast<std::size_t>(i); };
    std::vector<int> free(held.size(), -1);
    for (std::size_t i = 0; i < held.size(); ++i)
      if (!held[i]) {
        free[i] = static_cast<int>(unknown_.size());
        unknown_.push_back(i);
      }
    const auto size = static_cast<Eigen::Index>(unknown_.size());
    matrix_.resize(size, size);
    std::vector<int> start{0};
    std::vector<int> row;
    for (const std::size_t unknown : unknown_) { // a column; the pattern of blocks is symmetric
      const auto j = static_cast<std::int32_t>(unknown / n);
      for (std::int32_t k = pattern.row_start[at(j)]; k < pattern.row_start[at(j) + 1]; ++k) {
        const std::int32_t i = pattern.column[at(k)];
        const auto block = at(pattern.find(i, j)) * n * n;
        for (std::size_t a = 0; a < n; ++a)
          if (const int r = free[at(i) * n + a]; r >= 0) {
            row.push_back(r);
            source_.push_back(block + unknown % n * n + a);
          }
      }
      start.push_back(static_cast<int>(row.size()));
    }
    matrix_.resizeNonZeros(static_cast<Eigen::Index>(row.size()));
    std::copy(start.begin(), start.end(), matrix_.outerIndexPtr());
    std::copy(row.begin(), row.end(), matrix_.innerIndexPtr());
    values_.resize(unknown_.size());
  }

  /// False when the matrix is singular.
  [[nodiscard]] Result<bool> factor(const la::BlockMatrix<n>& A) {
    const float* values = A.block(0);
    for (std::size_t k = 0; k < source_.size(); ++k)
      matrix_.valuePtr()[k] = static_cast<double>(values[source_[k]]);
    return lu_.factor(matrix_);
  }

  /// @pre factor() returned true
  [[nodiscard]] Result<void> solve(std::span<const double> b, std::span<double> x) {
    for (std::size_t i = 0; i < unknown_.size(); ++i) values_[i] = b[unknown_[i]];
    DROGUE_TRY(lu_.solve(values_, values_));
    std::fill(x.begin(), x.end(), 0.0);
    for (std::size_t i = 0; i < unknown_.size(); ++i) x[unknown_[i]] = values_[i];
    return {};
  }

 private:
  std::vector<std::size_t> unknown_; ///< of each equation: place in {rows, n}
  std::vector<std::size_t> source_;  ///< of each entry: place in the block matrix
  la::SparseMatrix matrix_;
  la::LuSolver lu_{la::LuSolver::Refinement::none};
  std::vector<double> values_;
};

} // namespace drogue::fluid
