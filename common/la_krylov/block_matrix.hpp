// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/cache_lines.hpp"
#include "common/la_krylov/node_graph.hpp"

/// One rank's rows of a matrix of dense blocks, in single precision. A Jacobian and its preconditioner need
/// no more: residuals and states are double, and the solver moves half the memory. Blocks are column-major.
namespace drogue::la {

template <int block_size>
class BlockMatrix {
 public:
  static constexpr int entries = block_size * block_size;

  /// All blocks zero. `pattern` must outlive the matrix.
  explicit BlockMatrix(const LocalPattern& pattern)
      : pattern_(&pattern), values_(pattern.column.size() * entries) {}

  [[nodiscard]] const LocalPattern& pattern() const { return *pattern_; }
  [[nodiscard]] float* block(std::int32_t position) {
    return values_.data() + static_cast<std::size_t>(position) * entries;
  }
  [[nodiscard]] const float* block(std::int32_t position) const {
    return values_.data() + static_cast<std::size_t>(position) * entries;
  }
  /// Makes scalar row `component` of block row `row` that of the identity.
  void set_identity_row(std::int32_t row, int component);

  /// y = A x; x {columns, block_size} own values and ghosts, y {rows, block_size}.
  void multiply(const double* x, double* y) const noexcept;

 private:
  const LocalPattern* pattern_;
  CacheLines<float> values_;
};

/// Scalar rows 3, 7, ... (one of every four) of a block matrix once more, close together: a defect in these
/// rows alone reads a quarter of the memory.
template <int block_size>
class FourthRows {
 public:
  /// `pattern` must outlive the object.
  explicit FourthRows(const LocalPattern& pattern)
      : pattern_(&pattern), values_(pattern.column.size() * block_size * block_size / 4) {}

  void copy(const BlockMatrix<block_size>& A) noexcept;
  /// r - A x in these rows: out {rows, block_size / 4}; x {columns, block_size}. @pre copy()
  void defect(const double* r, const double* x, double* out) const noexcept;

 private:
  const LocalPattern* pattern_;
  CacheLines<float> values_;
};

/// Incomplete factorisation without fill, by blocks, of the square part of a rank's rows (couplings to ghosts
/// are left out: block Jacobi between ranks). Diagonal blocks are inverted. Factored in single precision,
/// then cut to 16 bits (the range of single precision, 8 bits of mantissa): a preconditioner needs no more,
/// and its application moves half the memory.
template <int block_size>
class BlockIlu {
 public:
  static constexpr int entries = block_size * block_size;

  explicit BlockIlu(const LocalPattern& pattern);
  /// Returns the row whose pivot block is singular, if one is. @post apply() may be called when none is
  [[nodiscard]] std::optional<std::int32_t> factor(const BlockMatrix<block_size>& A);
  /// z = (L U)^-1 r, both {rows, block_size}.
  void apply(const double* r, double* z) noexcept;

 private:
  const LocalPattern* pattern_;
  CacheLines<float> values_;
  CacheLines<float> work_;
  std::vector<std::int32_t> position_;
};

extern template class BlockMatrix<4>;
extern template class BlockMatrix<8>;
extern template class FourthRows<4>;
extern template class FourthRows<8>;
extern template class BlockIlu<4>;
extern template class BlockIlu<8>;

} // namespace drogue::la
