// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "common/la_krylov/row_exchange.hpp"
#include "mesh_mover/row_parts.hpp"

namespace drogue::mesh_mover {

/// The rows of a matrix shared out among ranks. Arrays {rows, 3} are whole on every rank; of their values
/// each keeps its own rows up to date.
class SharedRows {
 public:
  /// All of them on this process, whatever other ranks there are.
  explicit SharedRows(const SymmetricBlocks<double>& A) : own_{0, A.rows()} {}
  /// Every rank has the same pattern.
  [[nodiscard]] static SharedRows among_all_ranks(const SymmetricBlocks<double>& A);

  [[nodiscard]] RowRange own() const noexcept { return own_; }
  /// Brings the rows that the own ones are coupled with. @note Collective
  void fetch(std::span<double> x) { exchange_.update(x); }
  /// Makes x whole on every rank. @note Collective
  void gather(std::span<double> x) const;
  /// Sums of values over the ranks, in place. @note Collective
  void sum(std::span<double> values) const;
  [[nodiscard]] double sum(double value) const;

 private:
  RowRange own_;
  std::vector<RowRange> ranges_; // of the ranks; empty: this process is alone
  la::RowExchange exchange_;
};

} // namespace drogue::mesh_mover
