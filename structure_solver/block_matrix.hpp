// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/la_direct/direct_solver.hpp"

namespace drogue::structure {

/// A sparse matrix of 3 x 3 blocks between nodes, kept in compressed sparse columns so that the direct
/// solvers take it as it is. The pattern is fixed; symmetric in structure.
class BlockMatrix {
 public:
  /// @param pairs pairs of coupled nodes, in one order each; the diagonal is always there
  /// @param marked {3 nodes}: 1 for the equations that eliminate_marked() takes out
  BlockMatrix(std::int32_t node_count, std::span<const std::pair<std::int32_t, std::int32_t>> pairs,
              std::span<const std::uint8_t> marked);

  /// Position of the block (row node, column node) in its column. @pre the block is in the pattern
  [[nodiscard]] std::int32_t slot(std::int32_t row, std::int32_t column) const;

  /// The three columns of a node: entry (r, c) of the block in `slot` is value[c * height + 3 * slot + r].
  struct BlockColumn {
    double* value;
    std::int32_t height;
  };
  [[nodiscard]] BlockColumn column(std::int32_t node) noexcept {
    const auto j = static_cast<std::size_t>(node);
    return {matrix_.valuePtr() + 9 * static_cast<std::ptrdiff_t>(first_[j]), 3 * (first_[j + 1] - first_[j])};
  }
  void set_zero(std::int32_t node) noexcept {
    const BlockColumn c = column(node);
    std::fill_n(c.value, 3 * c.height, 0.0);
  }
  /// Adds `value` to the three diagonal entries of a node.
  void add_diagonal(std::int32_t node, double value) noexcept {
    const BlockColumn c = column(node);
    double* entry = c.value + 3 * diagonal_[static_cast<std::size_t>(node)];
    for (int k = 0; k < 3; ++k, entry += c.height + 1) *entry += value;
  }
  /// Rows and columns of the equations that were marked at construction become those of the identity.
  void eliminate_marked() noexcept;

  [[nodiscard]] const la::SparseMatrix& matrix() const { return matrix_; }

 private:
  std::vector<std::int32_t> first_;       // first block of each column node
  std::vector<std::int32_t> rows_;        // row nodes, sorted within a column
  std::vector<std::int32_t> diagonal_;    // slot of each node's diagonal block
  std::vector<std::int32_t> eliminated_;  // entries off the diagonal in marked rows or columns
  std::vector<std::int32_t> marked_ones_; // diagonal entries of the marked
  la::SparseMatrix matrix_;
};

} // namespace drogue::structure
