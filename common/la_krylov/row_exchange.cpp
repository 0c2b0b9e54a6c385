// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/la_krylov/row_exchange.hpp"

#include <algorithm>

#include <mpi.h>

namespace drogue::la {

RowExchange::RowExchange(std::vector<Neighbour> neighbours, int components)
    : neighbours_(std::move(neighbours)), components_(static_cast<std::size_t>(components)) {
  for (Neighbour& n : neighbours_) {
    n.outgoing.resize(components_ * n.send.size());
    n.incoming.resize(components_ * n.receive.size());
  }
}

void RowExchange::update(std::span<double> x) {
  if (neighbours_.empty()) return; // perhaps without a session
  std::vector<MPI_Request> requests;
  requests.reserve(2 * neighbours_.size());
  const auto row = [&](std::int32_t i) { return x.data() + components_ * static_cast<std::size_t>(i); };
  for (Neighbour& n : neighbours_) {
    MPI_Irecv(n.incoming.data(), static_cast<int>(n.incoming.size()), MPI_DOUBLE, n.rank, 0, MPI_COMM_WORLD,
              &requests.emplace_back());
    for (std::size_t k = 0; k < n.send.size(); ++k)
      std::copy_n(row(n.send[k]), components_, n.outgoing.data() + components_ * k);
    MPI_Isend(n.outgoing.data(), static_cast<int>(n.outgoing.size()), MPI_DOUBLE, n.rank, 0, MPI_COMM_WORLD,
              &requests.emplace_back());
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  for (const Neighbour& n : neighbours_)
    for (std::size_t k = 0; k < n.receive.size(); ++k)
      std::copy_n(n.incoming.data() + components_ * k, components_, row(n.receive[k]));
}

} // namespace drogue::la
