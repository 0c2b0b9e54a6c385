// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace drogue::la {

/// Which nodes share an element: compressed rows, sorted, each node a neighbour of itself.
struct NodeGraph {
  std::vector<std::int32_t> row_start;
  std::vector<std::int32_t> column;

  [[nodiscard]] std::int32_t size() const { return static_cast<std::int32_t>(row_start.size()) - 1; }
  [[nodiscard]] std::span<const std::int32_t> row(std::int32_t i) const {
    const auto b = static_cast<std::size_t>(row_start[static_cast<std::size_t>(i)]);
    const auto e = static_cast<std::size_t>(row_start[static_cast<std::size_t>(i) + 1]);
    return {column.data() + b, e - b};
  }
};

/// Graph of `node_count` nodes from elements of `nodes_per_element` nodes each.
[[nodiscard]] NodeGraph node_graph(std::int32_t node_count, std::span<const std::int32_t> elements,
                                   int nodes_per_element);

/// Reverse Cuthill-McKee ordering: entry new -> old. Every component starts at its first node of smallest
/// degree.
[[nodiscard]] std::vector<std::int32_t> reverse_cuthill_mckee(const NodeGraph& graph);

/// Rows [first, last) that a rank owns: equal shares of the graph's entries, contiguous.
struct RowRange {
  std::int32_t first = 0;
  std::int32_t last = 0;
  [[nodiscard]] std::int32_t size() const { return last - first; }
  [[nodiscard]] bool has(std::int32_t i) const { return i >= first && i < last; }
};
[[nodiscard]] std::vector<RowRange> partition_rows(const NodeGraph& graph, int parts);

/// One rank's rows of a graph in local numbers: own nodes first, then ghosts, both in ascending global order.
struct LocalPattern {
  std::int32_t rows = 0;
  std::vector<std::int32_t> ghosts; ///< global numbers
  std::vector<std::int32_t> row_start;
  std::vector<std::int32_t> column;   ///< local numbers, ascending in each row
  std::vector<std::int32_t> diagonal; ///< position of each row's diagonal entry

  [[nodiscard]] std::int32_t columns() const { return rows + static_cast<std::int32_t>(ghosts.size()); }
  /// Position of entry (row, column), local numbers; -1 when it is not in the pattern.
  [[nodiscard]] std::int32_t find(std::int32_t row, std::int32_t col) const;
  /// Local number of a global node; -1 when it is neither own nor ghost.
  [[nodiscard]] std::int32_t local(const RowRange& own, std::int32_t global) const;
};
[[nodiscard]] LocalPattern local_pattern(const NodeGraph& graph, const RowRange& own);

} // namespace drogue::la
