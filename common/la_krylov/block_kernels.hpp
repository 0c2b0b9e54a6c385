// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>

/// The loops behind BlockMatrix, FourthRows and BlockIlu, compiled for each instruction set. Blocks are n x
/// n, column-major, in single precision; those of the factor are rounded to the upper 16 bits of it.
namespace drogue::la {

/// LocalPattern in plain pointers.
struct BlockRows {
  std::int32_t rows = 0;
  const std::int32_t* row_start = nullptr;
  const std::int32_t* column = nullptr;
  const std::int32_t* diagonal = nullptr;
};

template <int n>
struct BlockKernels {
  /// y = A x
  void (*multiply)(const BlockRows& p, const float* A, const double* x, double* y) noexcept;
  /// Rows 3, 7, ... of each block to rows {entries, n / 4, n}.
  void (*copy_fourth_rows)(std::size_t entries, const float* A, float* rows) noexcept;
  /// out {rows, n / 4} = r - A x in these rows.
  void (*fourth_row_defect)(const BlockRows& p, const float* fourth_rows, const double* r, const double* x,
                            double* out) noexcept;
  /// Incomplete factorisation in place; position {columns} holds -1 before and after. Returns the row of a
  /// singular pivot, or -1.
  std::int32_t (*factor)(const BlockRows& p, float* A, std::int32_t* position) noexcept;
  /// Rounds the factor's values to 16 bits, two columns in a word, and puts them into the second half of
  /// their memory in the order in which solve() reads them: L row by row, then from the last row on the row
  /// of U and its pivot's inverse. So nothing is fetched that is not wanted then.
  void (*pack)(const BlockRows& p, float* A) noexcept;
  /// z = (L U)^-1 r with the packed factor; work {rows, n}.
  void (*solve)(const BlockRows& p, const float* LU, const double* r, float* work, double* z) noexcept;
};

namespace baseline {
extern const BlockKernels<4> block_kernels_4;
extern const BlockKernels<8> block_kernels_8;
} // namespace baseline
namespace avx2 {
extern const BlockKernels<4> block_kernels_4;
extern const BlockKernels<8> block_kernels_8;
} // namespace avx2
namespace avx512 {
extern const BlockKernels<4> block_kernels_4;
extern const BlockKernels<8> block_kernels_8;
} // namespace avx512

/// For the processor at hand. n = 4 or 8.
template <int n>
[[nodiscard]] const BlockKernels<n>& block_kernels();
template <>
const BlockKernels<4>& block_kernels<4>();
template <>
const BlockKernels<8>& block_kernels<8>();

} // namespace drogue::la
