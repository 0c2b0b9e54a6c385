// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace drogue::la {

/// Rows of a replicated array {rows, components}, of which every rank keeps its own up to date: brings those
/// that this rank needs from their owners.
class RowExchange {
 public:
  /// What goes between this rank and another one; the other's lists are the same with the roles exchanged.
  struct Neighbour {
    int rank = 0;
    std::vector<std::int32_t> send; ///< own rows, ascending
    std::vector<std::int32_t> receive;
    std::vector<double> outgoing, incoming;
  };
  RowExchange() = default;
  RowExchange(std::vector<Neighbour> neighbours, int components);

  /// @note Collective among neighbours
  void update(std::span<double> x);

 private:
  std::vector<Neighbour> neighbours_;
  std::size_t components_ = 0;
};

} // namespace drogue::la
