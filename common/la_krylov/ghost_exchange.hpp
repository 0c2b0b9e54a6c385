// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/la_krylov/node_graph.hpp"

namespace drogue::la {

/// Brings ghost values from their owners. Built without communication: every rank knows the graph and the
/// ranges.
class GhostExchange {
 public:
  GhostExchange(const NodeGraph& graph, std::span<const RowRange> ranges, const LocalPattern& pattern,
                int rank, int components);
  /// x {columns, components}: own values first; the ghosts behind them are filled. @note Collective
  void update(std::span<double> x);

 private:
  struct Neighbour {
    int rank = 0;
    std::vector<std::int32_t> send; ///< own local numbers, in the neighbour's ghost order
    std::size_t receive_at = 0;     ///< first ghost value in x
    std::size_t receive_count = 0;
    std::vector<double> buffer;
  };
  std::vector<Neighbour> neighbours_;
  int components_;
};

/// Puts every rank's share of a replicated array {rows, components} together. @note Collective
void gather_to_all(std::span<const RowRange> ranges, int components, std::span<const double> own,
                   std::span<double> all);

} // namespace drogue::la
