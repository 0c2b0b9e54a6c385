// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "mesh_mover/block_matrix.hpp"

namespace drogue::mesh_mover {

/// Neighbours of each node in the pattern of a matrix, in ascending order.
class Graph {
 public:
  explicit Graph(const SymmetricBlocks<double>& A) : start_(A.rows() + 1, 0) {
    for_each_pair(A, [&](std::size_t i, std::size_t j) {
      ++start_[i + 1];
      ++start_[j + 1];
    });
    for (std::size_t i = 0; i < A.rows(); ++i) start_[i + 1] += start_[i];
    neighbours_.resize(start_.back());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for_each_pair(A, [&](std::size_t i, std::size_t j) {
      neighbours_[next[i]++] = static_cast<std::int32_t>(j);
      neighbours_[next[j]++] = static_cast<std::int32_t>(i);
    });
  }
  [[nodiscard]] std::span<const std::int32_t> neighbours(std::size_t node) const {
    return {neighbours_.data() + start_[node], start_[node + 1] - start_[node]};
  }

 private:
  template <class Visit>
  static void for_each_pair(const SymmetricBlocks<double>& A, Visit&& visit) {
    for (std::size_t i = 0; i < A.rows(); ++i)
      for (std::size_t k = A.begin(i); k < A.diagonal(i); ++k)
        visit(i, static_cast<std::size_t>(A.column[k]));
  }

  std::vector<std::size_t> start_;
  std::vector<std::int32_t> neighbours_;
};

} // namespace drogue::mesh_mover
