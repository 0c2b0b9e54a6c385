// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/la_krylov/block_matrix.hpp"

#include <cstring>

#include "common/base/isa.hpp"
#include "common/la_krylov/block_kernels.hpp"

namespace drogue::la {

template <>
const BlockKernels<4>& block_kernels<4>() {
  static const BlockKernels<4>* const of[] = {&baseline::block_kernels_4, &avx2::block_kernels_4,
                                              &avx512::block_kernels_4};
  return *of[static_cast<int>(best_isa())];
}
template <>
const BlockKernels<8>& block_kernels<8>() {
  static const BlockKernels<8>* const of[] = {&baseline::block_kernels_8, &avx2::block_kernels_8,
                                              &avx512::block_kernels_8};
  return *of[static_cast<int>(best_isa())];
}

namespace {

BlockRows rows_of(const LocalPattern& p) {
  return {p.rows, p.row_start.data(), p.column.data(), p.diagonal.data()};
}

} // namespace

template <int n>
void BlockMatrix<n>::set_identity_row(std::int32_t row, int component) {
  const auto r = static_cast<std::size_t>(row);
  for (std::int32_t k = pattern_->row_start[r]; k < pattern_->row_start[r + 1]; ++k)
    for (int j = 0; j < n; ++j) block(k)[j * n + component] = 0;
  block(pattern_->diagonal[r])[component * n + component] = 1;
}

template <int n>
void BlockMatrix<n>::multiply(const double* x, double* y) const noexcept {
  block_kernels<n>().multiply(rows_of(*pattern_), values_.data(), x, y);
}

template <int n>
void FourthRows<n>::copy(const BlockMatrix<n>& A) noexcept {
  block_kernels<n>().copy_fourth_rows(pattern_->column.size(), A.block(0), values_.data());
}

template <int n>
void FourthRows<n>::defect(const double* r, const double* x, double* out) const noexcept {
  block_kernels<n>().fourth_row_defect(rows_of(*pattern_), values_.data(), r, x, out);
}

template <int n>
BlockIlu<n>::BlockIlu(const LocalPattern& pattern)
    : pattern_(&pattern),
      values_(pattern.column.size() * entries),
      work_(static_cast<std::size_t>(pattern.rows) * n),
      position_(static_cast<std::size_t>(pattern.columns()), -1) {}

template <int n>
std::optional<std::int32_t> BlockIlu<n>::factor(const BlockMatrix<n>& A) {
  std::memcpy(values_.data(), A.block(0), values_.size() * sizeof(float));
  const std::int32_t singular =
      block_kernels<n>().factor(rows_of(*pattern_), values_.data(), position_.data());
  if (singular >= 0) return singular;
  block_kernels<n>().pack(rows_of(*pattern_), values_.data());
  return std::nullopt;
}

template <int n>
void BlockIlu<n>::apply(const double* r, double* z) noexcept {
  block_kernels<n>().solve(rows_of(*pattern_), values_.data(), r, work_.data(), z);
}

template class BlockMatrix<4>;
template class BlockMatrix<8>;
template class FourthRows<4>;
template class FourthRows<8>;
template class BlockIlu<4>;
template class BlockIlu<8>;

} // namespace drogue::la
