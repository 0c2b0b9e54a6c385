// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/numbering.hpp"

#include <algorithm>

#include "mesh_mover/block_matrix.hpp"
#include "mesh_mover/graph.hpp"

namespace drogue::mesh_mover {
namespace {

constexpr std::int32_t unnumbered = -1;

/// Breadth-first levels from `start` over unnumbered nodes, neighbours in the order of their degrees. Returns
/// the nodes in the order of their visit; `level` {nodes} must be unnumbered for all nodes and is left so.
std::vector<std::int32_t> breadth_first(const Graph& graph, std::int32_t start,
                                        std::vector<std::int32_t>& level) {
  std::vector<std::int32_t> order = {start};
  level[static_cast<std::size_t>(start)] = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const auto i = static_cast<std::size_t>(order[k]);
    const auto first_new = static_cast<std::ptrdiff_t>(order.size());
    for (const std::int32_t j : graph.neighbours(i)) {
      if (level[static_cast<std::size_t>(j)] != unnumbered) continue;
      level[static_cast<std::size_t>(j)] = level[i] + 1;
      order.push_back(j);
    }
    std::stable_sort(order.begin() + first_new, order.end(), [&](std::int32_t a, std::int32_t b) {
      return graph.neighbours(static_cast<std::size_t>(a)).size() <
             graph.neighbours(static_cast<std::size_t>(b)).size();
    });
  }
  return order;
}

} // namespace

std::vector<std::int32_t> reverse_cuthill_mckee(const Cells& cells, std::size_t node_count) {
  const Graph graph(lower_pattern(cells, node_count));
  std::vector<std::int32_t> level(node_count, unnumbered);
  std::vector<std::int32_t> number(node_count, unnumbered);
  std::int32_t next = 0;
  for (std::size_t seed = 0; seed < node_count; ++seed) {
    if (number[seed] != unnumbered) continue;
    // The node visited last is far from the seed: starting there makes many small levels.
    auto order = breadth_first(graph, static_cast<std::int32_t>(seed), level);
    const std::int32_t far = order.back();
    for (const std::int32_t node : order) level[static_cast<std::size_t>(node)] = unnumbered;
    order = breadth_first(graph, far, level);
    for (auto node = order.rbegin(); node != order.rend(); ++node)
      number[static_cast<std::size_t>(*node)] = next++;
  }
  return number;
}

} // namespace drogue::mesh_mover
