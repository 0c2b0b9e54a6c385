// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/shared_rows.hpp"

#include <algorithm>

#include "common/la_krylov/ghost_exchange.hpp"
#include "common/la_krylov/session.hpp"

namespace drogue::mesh_mover {
namespace {

void make_a_set(std::vector<std::int32_t>& rows) {
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
}

/// A block (i, j) makes the owner of i need row j, and the owner of j row i.
std::vector<la::RowExchange::Neighbour> neighbours_of(const SymmetricBlocks<double>& A,
                                                      const std::vector<RowRange>& ranges, std::size_t rank) {
  std::vector<la::RowExchange::Neighbour> all(ranges.size());
  const auto owner = [&](std::size_t row) {
    const auto ends_before = [](std::size_t i, const RowRange& range) { return i < range.last; };
    return static_cast<std::size_t>(std::upper_bound(ranges.begin(), ranges.end(), row, ends_before) -
                                    ranges.begin());
  };
  const RowRange own = ranges[rank];
  const auto link = [&](std::size_t mine, std::size_t other) {
    la::RowExchange::Neighbour& neighbour = all[owner(other)];
    neighbour.send.push_back(static_cast<std::int32_t>(mine));
    neighbour.receive.push_back(static_cast<std::int32_t>(other));
  };
  for (std::size_t i = 0; i < A.rows(); ++i)
    for (std::size_t k = A.begin(i); k < A.diagonal(i); ++k) {
      const auto j = static_cast<std::size_t>(A.column[k]);
      if (own.has(i) && !own.has(j)) link(i, j);
      if (own.has(j) && !own.has(i)) link(j, i);
    }
  std::vector<la::RowExchange::Neighbour> result;
  for (std::size_t r = 0; r < all.size(); ++r) {
    if (all[r].send.empty()) continue;
    make_a_set(all[r].send);
    make_a_set(all[r].receive);
    all[r].rank = static_cast<int>(r);
    result.push_back(std::move(all[r]));
  }
  return result;
}

} // namespace

SharedRows SharedRows::among_all_ranks(const SymmetricBlocks<double>& A) {
  SharedRows rows(A);
  if (la::rank_count() == 1) return rows;
  rows.ranges_ = equal_parts(A, rows.own_, la::rank_count());
  const auto rank = static_cast<std::size_t>(la::rank());
  rows.own_ = rows.ranges_[rank];
  rows.exchange_ = la::RowExchange(neighbours_of(A, rows.ranges_, rank), 3);
  return rows;
}

void SharedRows::gather(std::span<double> x) const {
  if (ranges_.empty()) return;
  std::vector<la::RowRange> ranges;
  for (const RowRange& range : ranges_)
    ranges.push_back({static_cast<std::int32_t>(range.first), static_cast<std::int32_t>(range.last)});
  const std::vector<double> own(x.begin() + static_cast<std::ptrdiff_t>(3 * own_.first),
                                x.begin() + static_cast<std::ptrdiff_t>(3 * own_.last));
  la::gather_to_all(ranges, 3, own, x);
}

void SharedRows::sum(std::span<double> values) const {
  if (!ranges_.empty()) la::sum_over_ranks(values.data(), static_cast<int>(values.size()));
}

double SharedRows::sum(double value) const {
  sum({&value, 1});
  return value;
}

} // namespace drogue::mesh_mover
