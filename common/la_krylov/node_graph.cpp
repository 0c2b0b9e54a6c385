// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/la_krylov/node_graph.hpp"

#include <algorithm>
#include <numeric>

namespace drogue::la {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

} // namespace

NodeGraph node_graph(std::int32_t node_count, std::span<const std::int32_t> elements, int nodes_per_element) {
  const auto n = static_cast<std::size_t>(nodes_per_element);
  std::vector<std::size_t> start(at(node_count) + 1, 0);
  for (const std::int32_t i : elements) ++start[at(i) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<std::size_t> element_of(elements.size());
  std::vector<std::size_t> fill(start.begin(), start.end() - 1);
  for (std::size_t k = 0; k < elements.size(); ++k) element_of[fill[at(elements[k])]++] = k / n;

  NodeGraph graph;
  graph.row_start.assign(1, 0);
  graph.column.reserve(at(node_count) * 16);
  std::vector<std::int32_t> seen(at(node_count), -1);
  for (std::int32_t i = 0; i < node_count; ++i) {
    const auto row = static_cast<std::ptrdiff_t>(graph.column.size());
    seen[at(i)] = i;
    graph.column.push_back(i);
    for (std::size_t k = start[at(i)]; k < start[at(i) + 1]; ++k)
      for (const std::int32_t j : elements.subspan(element_of[k] * n, n))
        if (seen[at(j)] != i) {
          seen[at(j)] = i;
          graph.column.push_back(j);
        }
    std::sort(graph.column.begin() + row, graph.column.end());
    graph.row_start.push_back(static_cast<std::int32_t>(graph.column.size()));
  }
  return graph;
}

std::vector<std::int32_t> reverse_cuthill_mckee(const NodeGraph& graph) {
  const std::int32_t n = graph.size();
  std::vector<std::int32_t> order;
  order.reserve(at(n));
  std::vector<char> visited(at(n), 0);
  const auto by_degree = [&](std::int32_t a, std::int32_t b) {
    return graph.row(a).size() < graph.row(b).size();
  };
  std::vector<std::int32_t> starts(at(n));
  std::iota(starts.begin(), starts.end(), 0);
  std::stable_sort(starts.begin(), starts.end(), by_degree);
  std::vector<std::int32_t> next;
  for (const std::int32_t start : starts) {
    if (visited[at(start)]) continue;
    std::size_t head = order.size();
    order.push_back(start);
    visited[at(start)] = 1;
    while (head < order.size()) {
      next.clear();
      for (const std::int32_t j : graph.row(order[head++]))
        if (!visited[at(j)]) {
          visited[at(j)] = 1;
          next.push_back(j);
        }
      std::stable_sort(next.begin(), next.end(), by_degree);
      order.insert(order.end(), next.begin(), next.end());
    }
  }
  std::reverse(order.begin(), order.end());
  return order;
}

std::vector<RowRange> partition_rows(const NodeGraph& graph, int parts) {
  std::vector<RowRange> ranges(static_cast<std::size_t>(parts));
  const auto total = static_cast<std::int64_t>(graph.column.size());
  std::int32_t row = 0;
  for (int p = 0; p < parts; ++p) {
    RowRange& range = ranges[static_cast<std::size_t>(p)];
    range.first = row;
    while (row < graph.size() && graph.row_start[at(row)] < total * (p + 1) / parts) ++row;
    if (p + 1 == parts) row = graph.size();
    range.last = row;
  }
  return ranges;
}

std::int32_t LocalPattern::find(std::int32_t row, std::int32_t col) const {
  const auto begin = column.begin() + row_start[at(row)];
  const auto end = column.begin() + row_start[at(row) + 1];
  const auto it = std::lower_bound(begin, end, col);
  return it != end && *it == col ? static_cast<std::int32_t>(it - column.begin()) : -1;
}

std::int32_t LocalPattern::local(const RowRange& own, std::int32_t global) const {
  if (own.has(global)) return global - own.first;
  const auto it = std::lower_bound(ghosts.begin(), ghosts.end(), global);
  return it != ghosts.end() && *it == global ? rows + static_cast<std::int32_t>(it - ghosts.begin()) : -1;
}

LocalPattern local_pattern(const NodeGraph& graph, const RowRange& own) {
  LocalPattern pattern;
  pattern.rows = own.size();
  for (std::int32_t i = own.first; i < own.last; ++i)
    for (const std::int32_t j : graph.row(i))
      if (!own.has(j)) pattern.ghosts.push_back(j);
  std::sort(pattern.ghosts.begin(), pattern.ghosts.end());
  pattern.ghosts.erase(std::unique(pattern.ghosts.begin(), pattern.ghosts.end()), pattern.ghosts.end());
  pattern.row_start.assign(1, 0);
  for (std::int32_t i = own.first; i < own.last; ++i) {
    const auto row = static_cast<std::ptrdiff_t>(pattern.column.size());
    for (const std::int32_t j : graph.row(i)) pattern.column.push_back(pattern.local(own, j));
    std::sort(pattern.column.begin() + row, pattern.column.end());
    pattern.row_start.push_back(static_cast<std::int32_t>(pattern.column.size()));
    pattern.diagonal.push_back(pattern.find(i - own.first, i - own.first));
  }
  return pattern;
}

} // namespace drogue::la
