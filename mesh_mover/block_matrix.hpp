// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "mesh_mover/cells.hpp"

namespace drogue::mesh_mover {

/// A symmetric matrix of 3 x 3 blocks, one block row a node: the lower triangle in compressed rows, columns
/// ascending, so that a row ends with its diagonal block. Blocks are column-major.
template <class Real>
struct SymmetricBlocks {
  using Block = Eigen::Matrix<Real, 3, 3>;

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
    return Eigen::Map<const Block>(values.data() + 9 * place);
  }
  [[nodiscard]] Eigen::Map<Block> block(std::size_t place) noexcept {
    return Eigen::Map<Block>(values.data() + 9 * place);
  }
};

/// Nodes of every element coupled with one another. Values are zero.
[[nodiscard]] SymmetricBlocks<double> lower_pattern(const Cells& cells, std::size_t node_count);

/// Place of the block (row, column), row >= column. @pre the pattern holds it
[[nodiscard]] std::int32_t place_of(const SymmetricBlocks<double>& matrix, std::int32_t row,
                                    std::int32_t column) noexcept;

/// y = A x; `x` and `y` {3 rows}, different memory.
void multiply(const SymmetricBlocks<double>& A, std::span<const double> x, std::span<double> y) noexcept;

} // namespace drogue::mesh_mover
