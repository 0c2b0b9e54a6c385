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

} // namespace drogue::mesh_mover
