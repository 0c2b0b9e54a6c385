// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "mesh_mover/cells.hpp"

namespace drogue::mesh_mover {

/// A symmetric matrix of N x N blocks, 3 x 3 with one block row a node: the lower triangle in compressed
/// rows, columns ascending, so that a row ends with its diagonal block. Blocks are column-major.
template <class Real, int N = 3>
struct SymmetricBlocks {
  using Block = Eigen::Matrix<Real, N, N>;

  std::vector<std::int32_t> row_start;
  std::vector<std::int32_t> column;
  std::vector<Real> values;

  [[nodiscard]] std::size_t rows() const noexcept { return row_start.size() - 1; }
  [[nodiscard]] std::size_t begin(std::size_t row) const noexcept {
    return static_cast<std::size_t>(row_start[row]);
  }
  /// Place of the diagonal block of a row.
  [[nodiscard]] std::size_t diagonal(std::size_t row) const noexcept {
    return static_cast<std::size_t>(row_start[row + 1]) - 1;
  }
  [[nodiscard]] Eigen::Map<const Block> block(std::size_t place) const noexcept {
    return Eigen::Map<const Block>(values.data() + static_cast<std::size_t>(N * N) * place);
  }
  [[nodiscard]] Eigen::Map<Block> block(std::size_t place) noexcept {
    return Eigen::Map<Block>(values.data() + static_cast<std::size_t>(N * N) * place);
  }
};

/// Nodes of every element coupled with one another. Values are zero.
[[nodiscard]] SymmetricBlocks<double> lower_pattern(const Cells& cells, std::size_t node_count);

/// Place of the block (row, column), row >= column. @pre the pattern holds it
template <int N>
[[nodiscard]] std::int32_t place_of(const SymmetricBlocks<double, N>& matrix, std::int32_t row,
                                    std::int32_t column) noexcept {
  const auto begin = matrix.column.begin() + matrix.row_start[static_cast<std::size_t>(row)];
  const auto end = matrix.column.begin() + matrix.row_start[static_cast<std::size_t>(row) + 1];
  return static_cast<std::int32_t>(std::lower_bound(begin, end, column) - matrix.column.begin());
}

} // namespace drogue::mesh_mover
