// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/la_krylov/ghost_exchange.hpp"

#include <algorithm>

#include <mpi.h>

#include "common/la_krylov/session.hpp"

namespace drogue::la {

GhostExchange::GhostExchange(const NodeGraph& graph, std::span<const RowRange> ranges,
                             const LocalPattern& pattern, int rank, int components)
    : components_(components) {
  const RowRange own = ranges[static_cast<std::size_t>(rank)];
  for (std::size_t r = 0; r < ranges.size(); ++r) {
    if (static_cast<int>(r) == rank) continue;
    Neighbour n;
    n.rank = static_cast<int>(r);
    // The graph is symmetric: the other rank needs exactly my nodes that touch one of its nodes.
    for (std::int32_t i = own.first; i < own.last; ++i) {
      const auto row = graph.row(i);
      if (std::any_of(row.begin(), row.end(), [&](std::int32_t j) { return ranges[r].has(j); }))
        n.send.push_back(i - own.first);
    }
    const auto first = std::lower_bound(pattern.ghosts.begin(), pattern.ghosts.end(), ranges[r].first);
    const auto last = std::lower_bound(pattern.ghosts.begin(), pattern.ghosts.end(), ranges[r].last);
    const auto width = static_cast<std::size_t>(components);
    n.receive_at =
        (static_cast<std::size_t>(pattern.rows) + static_cast<std::size_t>(first - pattern.ghosts.begin())) *
        width;
    n.receive_count = static_cast<std::size_t>(last - first) * width;
    n.buffer.resize(n.send.size() * width);
    if (!n.send.empty() || n.receive_count > 0) neighbours_.push_back(std::move(n));
  }
}

void GhostExchange::update(std::span<double> x) {
  std::vector<MPI_Request> requests;
  requests.reserve(2 * neighbours_.size());
  const auto width = static_cast<std::size_t>(components_);
  for (Neighbour& n : neighbours_) {
    MPI_Irecv(x.data() + n.receive_at, static_cast<int>(n.receive_count), MPI_DOUBLE, n.rank, 0,
              MPI_COMM_WORLD, &requests.emplace_back());
    for (std::size_t k = 0; k < n.send.size(); ++k)
      std::copy_n(x.data() + static_cast<std::size_t>(n.send[k]) * width, width, n.buffer.data() + k * width);
    MPI_Isend(n.buffer.data(), static_cast<int>(n.buffer.size()), MPI_DOUBLE, n.rank, 0, MPI_COMM_WORLD,
              &requests.emplace_back());
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

void gather_to_all(std::span<const RowRange> ranges, int components, std::span<const double> own,
                   std::span<double> all) {
  if (ranges.size() == 1) {
    std::copy(own.begin(), own.end(), all.begin());
    return;
  }
  std::vector<int> counts;
  std::vector<int> offsets;
  for (const RowRange& range : ranges) {
    counts.push_back(range.size() * components);
    offsets.push_back(range.first * components);
  }
  MPI_Allgatherv(own.data(), static_cast<int>(own.size()), MPI_DOUBLE, all.data(), counts.data(),
                 offsets.data(), MPI_DOUBLE, MPI_COMM_WORLD);
}

} // namespace drogue::la
