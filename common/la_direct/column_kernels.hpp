// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/cache_lines.hpp"

/// Triangular solutions with a sparse factor by columns, compiled for each instruction set. The right-hand
/// sides lie side by side in memory, `lanes` in a row of y.
namespace drogue::la {

/// L by compressed columns, the diagonal first, rows rising.
struct FactorColumns {
  std::int32_t n = 0;
  const std::int32_t* first = nullptr; ///< where each column starts
  const std::int32_t* count = nullptr; ///< its entries
  const std::int32_t* row = nullptr;
  const double* L = nullptr;
};

/// Columns that are done together have the same rows below their last diagonal, and all between.
inline constexpr int most_columns_together = 8;

/// L as a solution reads it, from the first value to the last and back: groups of columns that are done
/// together, each with the block on its diagonal, column by column, the diagonal inverted, and then its
/// common rows, row by row.
struct GroupedFactor {
  std::vector<std::int32_t> group{0};     ///< {groups + 1}: their first columns
  std::vector<std::int32_t> first_row{0}; ///< {groups + 1}: of `row`
  CacheLines<std::int32_t> row;
  CacheLines<double> value;
};
[[nodiscard]] GroupedFactor grouped(const FactorColumns& factor);

struct ColumnKernels {
  /// y = (L L^T)^-1 y, y {n, 4} or {n, 8}.
  void (*solve_4)(const GroupedFactor& factor, double* y) noexcept;
  void (*solve_8)(const GroupedFactor& factor, double* y) noexcept;
};

namespace baseline {
extern const ColumnKernels column_kernels;
}
namespace avx2 {
extern const ColumnKernels column_kernels;
}
namespace avx512 {
extern const ColumnKernels column_kernels;
}

/// For the processor at hand.
[[nodiscard]] const ColumnKernels& column_kernels();

} // namespace drogue::la
