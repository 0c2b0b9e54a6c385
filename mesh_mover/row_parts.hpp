// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "common/base/worker_pool.hpp"
#include "mesh_mover/block_matrix.hpp"

namespace drogue::mesh_mover {

/// The rows of a matrix in contiguous parts, one a thread, with about the same number of blocks. What is
/// computed depends on the number of parts, never on when a thread runs.
class RowParts {
 public:
  /// @param parts 0: as many as there are threads to use by default, fewer for small matrices
  explicit RowParts(const SymmetricBlocks<double>& A, int parts = 0);

  [[nodiscard]] int count() const noexcept { return pool_.size(); }
  [[nodiscard]] std::size_t begin(int part) const noexcept { return start_[static_cast<std::size_t>(part)]; }
  [[nodiscard]] std::size_t end(int part) const noexcept {
    return start_[static_cast<std::size_t>(part) + 1];
  }
  /// The part that holds a row.
  [[nodiscard]] int part_of(std::size_t row) const noexcept;

  /// job(part) for all parts at the same time.
  void run(const std::function<void(int)>& job) const { pool_.run(job); }

 private:
  mutable WorkerPool pool_;
  std::vector<std::size_t> start_;
};

/// y = A x with one thread a part.
class PartedProduct {
 public:
  /// `A` and `parts` must outlive this object; A's values may change.
  PartedProduct(const SymmetricBlocks<double>& A, const RowParts& parts);

  /// `x` and `y` {3 rows}, different memory.
  void multiply(std::span<const double> x, std::span<double> y);

 private:
  void multiply_part(int part, std::span<const double> x, std::span<double> y) noexcept;

  const SymmetricBlocks<double>& A_;
  const RowParts& parts_;
  std::vector<std::size_t> low_;             // of each part: the smallest column in it, or its first row
  std::vector<std::vector<double>> earlier_; // what a part adds to the rows from low_ to its first
};

} // namespace drogue::mesh_mover
