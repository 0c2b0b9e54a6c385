// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/la_krylov/block_matrix.hpp"

#include <cmath>
#include <cstring>
#include <utility>

namespace drogue::la {
namespace {

/// A column of a block, readable at any address.
template <class T, int n>
struct ColumnOf {
  using type __attribute__((vector_size(sizeof(T) * n), aligned(sizeof(T)), may_alias)) = T;
};
template <class T, int n>
using Column = typename ColumnOf<T, n>::type;

template <int n>
const Column<float, n>& column(const float* block, int j) {
  return *reinterpret_cast<const Column<float, n>*>(block + j * n);
}
template <int n>
Column<float, n>& column(float* block, int j) {
  return *reinterpret_cast<Column<float, n>*>(block + j * n);
}

/// Inverts a column-major block in double precision with partial pivoting. False when it is singular.
template <int n>
bool invert(const float* block, float* inverse) {
  double a[n][2 * n] = {};
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) a[i][j] = static_cast<double>(block[j * n + i]);
    a[i][n + i] = 1;
  }
  for (int k = 0; k < n; ++k) {
    int pivot = k;
    for (int i = k + 1; i < n; ++i)
      if (std::fabs(a[i][k]) > std::fabs(a[pivot][k])) pivot = i;
    if (!(std::fabs(a[pivot][k]) > 0) || !std::isfinite(a[pivot][k])) return false;
    if (pivot != k) std::swap(a[pivot], a[k]);
    const double scale = 1.0 / a[k][k];
    for (double& value : a[k]) value *= scale;
    for (int i = 0; i < n; ++i) {
      if (i == k) continue;
      const double factor = a[i][k];
      for (int j = k; j < 2 * n; ++j) a[i][j] -= factor * a[k][j];
    }
  }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) inverse[j * n + i] = static_cast<float>(a[i][n + j]);
  return true;
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
  using Wide = Column<double, n>;
  const float* b = values_.data();
  for (std::int32_t i = 0; i < pattern_->rows; ++i) {
    Wide even{};
    Wide odd{};
    for (std::int32_t k = pattern_->row_start[static_cast<std::size_t>(i)];
         k < pattern_->row_start[static_cast<std::size_t>(i) + 1]; ++k, b += entries) {
      const double* xj = x + static_cast<std::size_t>(pattern_->column[static_cast<std::size_t>(k)]) * n;
      for (int j = 0; j < n; j += 2) {
        even += __builtin_convertvector(column<n>(b, j), Wide) * xj[j];
        odd += __builtin_convertvector(column<n>(b, j + 1), Wide) * xj[j + 1];
      }
    }
    *reinterpret_cast<Wide*>(y + static_cast<std::size_t>(i) * n) = even + odd;
  }
}

template <int n>
void BlockMatrix<n>::fourth_row_defect(const double* r, const double* x, double* out) const noexcept {
  const float* b = values_.data();
  for (std::int32_t i = 0; i < pattern_->rows; ++i) {
    double sum[n / 4] = {};
    for (std::int32_t k = pattern_->row_start[static_cast<std::size_t>(i)];
         k < pattern_->row_start[static_cast<std::size_t>(i) + 1]; ++k, b += entries) {
      const double* xj = x + static_cast<std::size_t>(pattern_->column[static_cast<std::size_t>(k)]) * n;
      for (int j = 0; j < n; ++j)
        for (int q = 0; q < n / 4; ++q) sum[q] += static_cast<double>(b[j * n + 4 * q + 3]) * xj[j];
    }
    for (int q = 0; q < n / 4; ++q)
      out[static_cast<std::size_t>(i) * (n / 4) + static_cast<std::size_t>(q)] =
          r[static_cast<std::size_t>(i) * n + static_cast<std::size_t>(4 * q + 3)] - sum[q];
  }
}

template <int n>
BlockIlu<n>::BlockIlu(const LocalPattern& pattern)
    : pattern_(&pattern),
      values_(pattern.column.size() * entries),
      work_(static_cast<std::size_t>(pattern.rows) * n),
      position_(static_cast<std::size_t>(pattern.columns()), -1) {}

template <int n>
std::optional<std::int32_t> BlockIlu<n>::factor(const BlockMatrix<n>& A) {
  const LocalPattern& p = *pattern_;
  std::memcpy(values_.data(), A.block(0), values_.size() * sizeof(float));
  const auto block = [&](std::int32_t k) { return values_.data() + static_cast<std::size_t>(k) * entries; };
  const auto start = [&](std::int32_t i) { return p.row_start[static_cast<std::size_t>(i)]; };
  const auto col = [&](std::int32_t k) { return p.column[static_cast<std::size_t>(k)]; };
  const auto diagonal = [&](std::int32_t i) { return p.diagonal[static_cast<std::size_t>(i)]; };
  for (std::int32_t i = 0; i < p.rows; ++i) {
    for (std::int32_t k = start(i); k < start(i + 1); ++k) position_[static_cast<std::size_t>(col(k))] = k;
    for (std::int32_t k = start(i); k < diagonal(i); ++k) {
      const std::int32_t j = col(k);
      // 1. L_ij = A_ij D_jj^-1
      alignas(64) float l[entries];
      for (int c = 0; c < n; ++c) {
        Column<float, n> sum{};
        for (int q = 0; q < n; ++q) sum += column<n>(block(k), q) * block(diagonal(j))[c * n + q];
        column<n>(l, c) = sum;
      }
      std::memcpy(block(k), l, sizeof(l));
      // 2. A_im -= L_ij U_jm on the pattern
      for (std::int32_t m = diagonal(j) + 1; m < start(j + 1) && col(m) < p.rows; ++m) {
        const std::int32_t at = position_[static_cast<std::size_t>(col(m))];
        if (at < 0) continue;
        const float* u = block(m);
        float* target = block(at);
        for (int c = 0; c < n; ++c) {
          Column<float, n> sum = column<n>(target, c);
          for (int q = 0; q < n; ++q) sum -= column<n>(l, q) * u[c * n + q];
          column<n>(target, c) = sum;
        }
      }
    }
    // 3. the inverse of the pivot takes its place
    float inverse[entries];
    if (!invert<n>(block(diagonal(i)), inverse)) {
      std::fill(position_.begin(), position_.end(), -1); // the next factorisation starts clean
      return i;
    }
    std::memcpy(block(diagonal(i)), inverse, sizeof(inverse));
    for (std::int32_t k = start(i); k < start(i + 1); ++k) position_[static_cast<std::size_t>(col(k))] = -1;
  }
  return std::nullopt;
}

template <int n>
void BlockIlu<n>::apply(const double* r, double* z) noexcept {
  using Vector = Column<float, n>;
  const LocalPattern& p = *pattern_;
  float* x = work_.data();
  for (std::int32_t i = 0; i < p.rows; ++i) {
    const auto row = static_cast<std::size_t>(i);
    Vector even = __builtin_convertvector(*reinterpret_cast<const Column<double, n>*>(r + row * n), Vector);
    Vector odd{};
    const float* b = values_.data() + static_cast<std::size_t>(p.row_start[row]) * entries;
    for (std::int32_t k = p.row_start[row]; k < p.diagonal[row]; ++k, b += entries) {
      const float* xj = x + static_cast<std::size_t>(p.column[static_cast<std::size_t>(k)]) * n;
      for (int j = 0; j < n; j += 2) {
        even -= column<n>(b, j) * xj[j];
        odd -= column<n>(b, j + 1) * xj[j + 1];
      }
    }
    *reinterpret_cast<Vector*>(x + row * n) = even + odd;
  }
  for (std::int32_t i = p.rows - 1; i >= 0; --i) {
    const auto row = static_cast<std::size_t>(i);
    Vector even = *reinterpret_cast<const Vector*>(x + row * n);
    Vector odd{};
    const float* pivot = values_.data() + static_cast<std::size_t>(p.diagonal[row]) * entries;
    const float* b = pivot + entries;
    for (std::int32_t k = p.diagonal[row] + 1; k < p.row_start[row + 1]; ++k, b += entries) {
      const std::int32_t c = p.column[static_cast<std::size_t>(k)];
      if (c >= p.rows) break;
      const float* xj = x + static_cast<std::size_t>(c) * n;
      for (int j = 0; j < n; j += 2) {
        even -= column<n>(b, j) * xj[j];
        odd -= column<n>(b, j + 1) * xj[j + 1];
      }
    }
    even += odd;
    Vector solved{};
    for (int j = 0; j < n; ++j) solved += column<n>(pivot, j) * even[j];
    *reinterpret_cast<Vector*>(x + row * n) = solved;
    *reinterpret_cast<Column<double, n>*>(z + row * n) = __builtin_convertvector(solved, Column<double, n>);
  }
}

template class BlockMatrix<4>;
template class BlockMatrix<8>;
template class BlockIlu<4>;
template class BlockIlu<8>;

} // namespace drogue::la
