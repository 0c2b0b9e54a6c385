// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "common/base/worker_pool.hpp"
#include "mesh_mover/block_matrix.hpp"

namespace drogue::mesh_mover {

/// Rows [first, last).
struct RowRange {
  std::size_t first = 0;
  std::size_t last = 0;
  [[nodiscard]] bool has(std::size_t row) const noexcept { return first <= row && row < last; }
};

/// Contiguous parts of the rows `whole` with about the same number of blocks.
[[nodiscard]] std::vector<RowRange> equal_parts(const SymmetricBlocks<double>& A, RowRange whole, int parts);

/// The rows of a matrix in contiguous parts, one a thread, with about the same number of blocks. What is
/// computed depends on the number of parts, never on when a thread runs.
class RowParts {
 public:
  /// @param parts 0: as many as there are threads to use by default, fewer for small matrices
  explicit RowParts(const SymmetricBlocks<double>& A, int parts = 0) : RowParts(A, {0, A.rows()}, parts) {}
  /// Of the rows `own` alone; the others are not touched.
  RowParts(const SymmetricBlocks<double>& A, RowRange own, int parts);

  [[nodiscard]] int count() const noexcept { return pool_.size(); }
  [[nodiscard]] RowRange own() const noexcept { return {parts_.front().first, parts_.back().last}; }
  [[nodiscard]] std::size_t begin(int part) const noexcept {
    return parts_[static_cast<std::size_t>(part)].first;
  }
  [[nodiscard]] std::size_t end(int part) const noexcept {
    return parts_[static_cast<std::size_t>(part)].last;
  }
  /// The part that holds a row. @pre own().has(row)
  [[nodiscard]] int part_of(std::size_t row) const noexcept;

  /// job(part) for all parts at the same time.
  void run(const std::function<void(int)>& job) const { pool_.run(job); }

 private:
  mutable WorkerPool pool_;
  std::vector<RowRange> parts_;
};

/// y = A x with one thread a part; of y the parts' own rows.
class PartedProduct {
 public:
  /// `A` and `parts` must outlive this object; A's values may change.
  PartedProduct(const SymmetricBlocks<double>& A, const RowParts& parts);

  /// `x` and `y` {3 rows}, different memory.
  void multiply(std::span<const double> x, std::span<double> y);

 private:
  /// Block (row, column) of the lower triangle below the own rows.
  struct Below {
    std::size_t block, row, column;
  };
  void multiply_part(int part, std::span<const double> x, std::span<double> y) noexcept;

  const SymmetricBlocks<double>& A_;
  const RowParts& parts_;
  std::vector<std::size_t> low_;             // of each part: the smallest column in it, or its first row
  std::vector<std::vector<double>> earlier_; // what a part adds to the rows from low_ to its first
  std::vector<Below> below_;                 // blocks of later rows in the columns of the own ones
};

} // namespace drogue::mesh_mover
