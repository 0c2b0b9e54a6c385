// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/block_matrix.hpp"

#include <algorithm>

namespace drogue::mesh_mover {
namespace {

/// Elements around each node in compressed rows.
struct NodeElements {
  std::vector<std::size_t> start;
  std::vector<std::size_t> element;

  NodeElements(const Cells& cells, std::size_t node_count)
      : start(node_count + 1, 0), element(cells.nodes.size()) {
    for (const std::int32_t node : cells.nodes) ++start[static_cast<std::size_t>(node) + 1];
    for (std::size_t i = 0; i < node_count; ++i) start[i + 1] += start[i];
    std::vector<std::size_t> next(start.begin(), start.end() - 1);
    for (std::size_t k = 0; k < element.size(); ++k)
      element[next[static_cast<std::size_t>(cells.nodes[k])]++] = k / cells.nodes_per_cell();
  }
};

} // namespace

SymmetricBlocks<double> lower_pattern(const Cells& cells, std::size_t node_count) {
  const NodeElements around(cells, node_count);
  SymmetricBlocks<double> matrix;
  matrix.row_start.assign(1, 0);
  std::vector<std::int32_t> row;
  for (std::size_t i = 0; i < node_count; ++i) {
    const auto self = static_cast<std::int32_t>(i);
    row.assign(1, self);
    for (std::size_t k = around.start[i]; k < around.start[i + 1]; ++k)
      for (const std::int32_t node : cells.cell(around.element[k]))
        if (node < self) row.push_back(node);
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    matrix.column.insert(matrix.column.end(), row.begin(), row.end());
    matrix.row_start.push_back(static_cast<std::int32_t>(matrix.column.size()));
  }
  matrix.values.assign(9 * matrix.column.size(), 0.0);
  return matrix;
}

std::int32_t place_of(const SymmetricBlocks<double>& matrix, std::int32_t row, std::int32_t column) noexcept {
  const auto begin = matrix.column.begin() + matrix.row_start[static_cast<std::size_t>(row)];
  const auto end = matrix.column.begin() + matrix.row_start[static_cast<std::size_t>(row) + 1];
  return static_cast<std::int32_t>(std::lower_bound(begin, end, column) - matrix.column.begin());
}

void multiply(const SymmetricBlocks<double>& A, std::span<const double> x, std::span<double> y) noexcept {
  using Vector = Eigen::Vector3d;
  for (std::size_t i = 0; i < A.rows(); ++i) {
    const Vector x_i = Eigen::Map<const Vector>(&x[3 * i]);
    const std::size_t diagonal = A.diagonal(i);
    Vector y_i = A.block(diagonal) * x_i;
    for (std::size_t k = A.begin(i); k < diagonal; ++k) {
      const auto j = 3 * static_cast<std::size_t>(A.column[k]);
      const auto K = A.block(k);
      y_i.noalias() += K * Eigen::Map<const Vector>(&x[j]);
      Eigen::Map<Vector>(&y[j]).noalias() += K.transpose() * x_i;
    }
    Eigen::Map<Vector> target(&y[3 * i]);
    target = y_i; // later rows add to it
  }
}

} // namespace drogue::mesh_mover
