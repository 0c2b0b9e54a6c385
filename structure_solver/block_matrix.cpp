// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/block_matrix.hpp"

#include <algorithm>
#include <cassert>

namespace drogue::structure {

BlockMatrix::BlockMatrix(std::int32_t node_count,
                         std::span<const std::pair<std::int32_t, std::int32_t>> pairs,
                         std::span<const std::uint8_t> marked) {
  const auto n = static_cast<std::size_t>(node_count);
  std::vector<std::vector<std::int32_t>> neighbours(n);
  for (std::size_t i = 0; i < n; ++i) neighbours[i].push_back(static_cast<std::int32_t>(i));
  for (const auto& pair : pairs) {
    neighbours[static_cast<std::size_t>(pair.first)].push_back(pair.second);
    neighbours[static_cast<std::size_t>(pair.second)].push_back(pair.first);
  }
  first_.assign(1, 0);
  for (auto& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    rows_.insert(rows_.end(), list.begin(), list.end());
    first_.push_back(static_cast<std::int32_t>(rows_.size()));
  }

  const int size = 3 * node_count;
  matrix_.resize(size, size);
  matrix_.resizeNonZeros(9 * static_cast<Eigen::Index>(rows_.size()));
  int* outer = matrix_.outerIndexPtr();
  int* inner = matrix_.innerIndexPtr();
  int entry = 0;
  for (std::size_t j = 0; j < n; ++j)
    for (int c = 0; c < 3; ++c) {
      outer[3 * j + static_cast<std::size_t>(c)] = entry;
      for (auto k = static_cast<std::size_t>(first_[j]); k < static_cast<std::size_t>(first_[j + 1]); ++k)
        for (int r = 0; r < 3; ++r) inner[entry++] = 3 * rows_[k] + r;
    }
  outer[3 * n] = entry;
  for (std::int32_t i = 0; i < node_count; ++i) diagonal_.push_back(slot(i, i));
  std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
  for (std::size_t j = 0; j < marked.size(); ++j)
    for (int k = outer[j]; k < outer[j + 1]; ++k) {
      const auto i = static_cast<std::size_t>(inner[k]);
      if (!marked[i] && !marked[j]) continue;
      (i == j ? marked_ones_ : eliminated_).push_back(k);
    }
}

std::int32_t BlockMatrix::slot(std::int32_t row, std::int32_t column) const {
  const auto begin = rows_.begin() + first_[static_cast<std::size_t>(column)];
  const auto end = rows_.begin() + first_[static_cast<std::size_t>(column) + 1];
  const auto found = std::lower_bound(begin, end, row);
  assert(found != end && *found == row);
  return static_cast<std::int32_t>(found - begin);
}

void BlockMatrix::eliminate_marked() noexcept {
  double* value = matrix_.valuePtr();
  for (const std::int32_t k : eliminated_) value[k] = 0;
  for (const std::int32_t k : marked_ones_) value[k] = 1;
}

} // namespace drogue::structure
