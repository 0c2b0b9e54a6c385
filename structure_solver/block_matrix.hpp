// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/la_direct/direct_solver.hpp"

namespace drogue::structure {

/// A sparse matrix of 3 x 3 blocks between nodes, kept in compressed sparse columns so that the direct
/// solvers take it as it is. The pattern is fixed; symmetric in structure.
class BlockMatrix {
 public:
  /// @param pairs pairs of coupled nodes, in one order each; the diagonal is always there
  BlockMatrix(std::int32_t node_count, std::span<const std::pair<std::int32_t, std::int32_t>> pairs);

  /// Position of the block (row node, column node), for add(). @pre the block is in the pattern
  [[nodiscard]] std::int32_t slot(std::int32_t row, std::int32_t column) const;

  void set_zero();
  /// Adds `block` at (row, column), where `slot` = slot(row, column).
  void add(std::int32_t column, std::int32_t slot, const Eigen::Ref<const Eigen::Matrix3d>& block) noexcept {
    const auto j = static_cast<std::size_t>(column);
    const std::int32_t height = 3 * (first_[j + 1] - first_[j]);
    double* value = matrix_.valuePtr() + 9 * static_cast<std::ptrdiff_t>(first_[j]) + 3 * slot;
    for (int c = 0; c < 3; ++c, value += height)
      for (int r = 0; r < 3; ++r) value[r] += block(r, c);
  }
  /// Adds `value` to the three diagonal entries of a node.
  void add_diagonal(std::int32_t node, double value) noexcept;
  /// Rows and columns of the marked equations become those of the identity.
  void eliminate(std::span<const std::uint8_t> marked) noexcept;

  [[nodiscard]] const la::SparseMatrix& matrix() const { return matrix_; }

 private:
  std::vector<std::int32_t> first_; // first block of each column node
  std::vector<std::int32_t> rows_;  // row nodes, sorted within a column
  std::vector<std::int32_t> diagonal_;
  la::SparseMatrix matrix_;
};

} // namespace drogue::structure
