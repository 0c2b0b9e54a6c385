// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once for each instruction set: drogue_kernels in cmake/targets.cmake.
#include "common/la_krylov/block_kernels.hpp"

#include <cmath>
#include <cstring>

namespace drogue::la::DROGUE_ISA {
namespace {

/// n values side by side, readable at any address.
template <class T, int n>
struct ColumnOf {
  using type __attribute__((vector_size(sizeof(T) * n), aligned(sizeof(T)), may_alias)) = T;
};
template <class T, int n>
using Column = typename ColumnOf<T, n>::type;

template <int n, class T>
const Column<T, n>& column(const T* block, int j) {
  return *reinterpret_cast<const Column<T, n>*>(block + j * n);
}
template <int n, class T>
Column<T, n>& column(T* block, int j) {
  return *reinterpret_cast<Column<T, n>*>(block + j * n);
}

template <int n>
Column<float, n> as_floats(Column<std::uint32_t, n> bits) {
  Column<float, n> values;
  std::memcpy(&values, &bits, sizeof(values));
  return values;
}

/// sum -= B x for a halved block, its columns 2 m and 2 m + 1 in the lower and upper halves of n words each.
template <int n>
inline void subtract_product(const std::uint32_t* block, const float* x, Column<float, n> sum[4]) {
  for (int m = 0; m < n / 2; ++m) {
    const Column<std::uint32_t, n> pair = column<n>(block, m);
    sum[2 * m % 4] -= as_floats<n>(pair << 16) * x[2 * m];
    sum[2 * m % 4 + 1] -= as_floats<n>(pair & 0xffff0000U) * x[2 * m + 1];
  }
}

/// The bits of a value rounded to nearest even in the upper half, the lower zero.
std::uint32_t upper_half(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof(bits));
  return (bits + 0x7fffU + ((bits >> 16) & 1U)) & 0xffff0000U;
}

/// Halves blocks in place: they fill the first half of their memory.
template <int n>
void halve(std::size_t entries, float* A) {
  auto* to = reinterpret_cast<char*>(A);
  for (std::size_t k = 0; k < entries; ++k) {
    const float* block = A + k * n * n;
    std::uint32_t words[n * n / 2];
    for (int m = 0; m < n / 2; ++m)
      for (int i = 0; i < n; ++i)
        words[m * n + i] = upper_half(block[(2 * m + 1) * n + i]) | (upper_half(block[2 * m * n + i]) >> 16);
    std::memcpy(to + k * sizeof(words), words, sizeof(words));
  }
}

/// End of row i's entries within the square part.
inline std::int32_t square_end(const BlockRows& p, std::int32_t i) {
  std::int32_t end = p.row_start[i + 1];
  while (p.column[end - 1] >= p.rows) --end;
  return end;
}

template <int n>
void pack(const BlockRows& p, float* A) noexcept {
  constexpr std::size_t size = n * n * sizeof(float) / 2;
  const auto entries = static_cast<std::size_t>(p.row_start[p.rows]);
  halve<n>(entries, A);
  const auto* from = reinterpret_cast<const char*>(A);
  auto* to = reinterpret_cast<char*>(A) + size * entries;
  const auto move = [&](std::int32_t first, std::int32_t last) {
    const std::size_t bytes = size * static_cast<std::size_t>(last - first);
    std::memcpy(to, from + size * static_cast<std::size_t>(first), bytes);
    to += bytes;
  };
  for (std::int32_t i = 0; i < p.rows; ++i) move(p.row_start[i], p.diagonal[i]);
  for (std::int32_t i = p.rows - 1; i >= 0; --i) {
    move(p.diagonal[i] + 1, square_end(p, i));
    move(p.diagonal[i], p.diagonal[i] + 1);
  }
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
    for (int j = 0; j < 2 * n && pivot != k; ++j) {
      const double keep = a[pivot][j];
      a[pivot][j] = a[k][j];
      a[k][j] = keep;
    }
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

template <int n>
void multiply(const BlockRows& p, const float* A, const double* x, double* y) noexcept {
  using Wide = Column<double, n>;
  const float* b = A;
  for (std::int32_t i = 0; i < p.rows; ++i) {
    Wide even{};
    Wide odd{};
    for (std::int32_t k = p.row_start[i]; k < p.row_start[i + 1]; ++k, b += n * n) {
      const double* xj = x + static_cast<std::ptrdiff_t>(p.column[k]) * n;
      for (int j = 0; j < n; j += 2) {
        even += __builtin_convertvector(column<n>(b, j), Wide) * xj[j];
        odd += __builtin_convertvector(column<n>(b, j + 1), Wide) * xj[j + 1];
      }
    }
    column<n>(y, i) = even + odd;
  }
}

template <int n>
void copy_fourth_rows(std::size_t entries, const float* A, float* rows) noexcept {
  for (std::size_t k = 0; k < entries; ++k, A += n * n)
    for (int q = 0; q < n / 4; ++q)
      for (int j = 0; j < n; ++j) *rows++ = A[j * n + 4 * q + 3];
}

template <int n>
void fourth_row_defect(const BlockRows& p, const float* fourth_rows, const double* r, const double* x,
                       double* out) noexcept {
  using Wide = Column<double, n>;
  const float* b = fourth_rows;
  for (std::int32_t i = 0; i < p.rows; ++i) {
    Wide sum[n / 4] = {};
    for (std::int32_t k = p.row_start[i]; k < p.row_start[i + 1]; ++k, b += n * n / 4) {
      const Wide xj = column<n>(x, p.column[k]);
      for (int q = 0; q < n / 4; ++q) sum[q] += __builtin_convertvector(column<n>(b, q), Wide) * xj;
    }
    for (int q = 0; q < n / 4; ++q) {
      double total = 0;
      for (int j = 0; j < n; ++j) total += sum[q][j];
      out[static_cast<std::ptrdiff_t>(i) * (n / 4) + q] =
          r[static_cast<std::ptrdiff_t>(i) * n + 4 * q + 3] - total;
    }
  }
}

template <int n>
std::int32_t factor(const BlockRows& p, float* A, std::int32_t* position) noexcept {
  const auto block = [&](std::int32_t k) { return A + static_cast<std::ptrdiff_t>(k) * n * n; };
  for (std::int32_t i = 0; i < p.rows; ++i) {
    for (std::int32_t k = p.row_start[i]; k < p.row_start[i + 1]; ++k) position[p.column[k]] = k;
    for (std::int32_t k = p.row_start[i]; k < p.diagonal[i]; ++k) {
      const std::int32_t j = p.column[k];
      // 1. L_ij = A_ij D_jj^-1
      alignas(64) float l[n * n];
      for (int c = 0; c < n; ++c) {
        Column<float, n> sum{};
        for (int q = 0; q < n; ++q) sum += column<n>(block(k), q) * block(p.diagonal[j])[c * n + q];
        column<n>(l, c) = sum;
      }
      std::memcpy(block(k), l, sizeof(l));
      // 2. A_im -= L_ij U_jm on the pattern
      for (std::int32_t m = p.diagonal[j] + 1; m < p.row_start[j + 1] && p.column[m] < p.rows; ++m) {
        const std::int32_t at = position[p.column[m]];
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
    float inverse[n * n];
    const bool regular = invert<n>(block(p.diagonal[i]), inverse);
    if (regular) std::memcpy(block(p.diagonal[i]), inverse, sizeof(inverse));
    for (std::int32_t k = p.row_start[i]; k < p.row_start[i + 1]; ++k) position[p.column[k]] = -1;
    if (!regular) return i;
  }
  return -1;
}

template <int n>
void solve(const BlockRows& p, const float* LU, const double* r, float* x, double* z) noexcept {
  using Vector = Column<float, n>;
  constexpr std::ptrdiff_t size = n * n / 2; // words
  const auto entries = static_cast<std::ptrdiff_t>(p.row_start[p.rows]);
  const auto* block = reinterpret_cast<const std::uint32_t*>(LU) + size * entries;
  const auto part = [&](std::int32_t i) { return x + static_cast<std::ptrdiff_t>(i) * n; };
  for (std::int32_t i = 0; i < p.rows; ++i) {
    Vector sum[4] = {__builtin_convertvector(column<n>(r, i), Vector)};
    for (std::int32_t k = p.row_start[i]; k < p.diagonal[i]; ++k, block += size)
      subtract_product<n>(block, part(p.column[k]), sum);
    column<n>(x, i) = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }
  for (std::int32_t i = p.rows - 1; i >= 0; --i) {
    Vector sum[4] = {column<n>(x, i)};
    const std::int32_t end = p.row_start[i + 1];
    for (std::int32_t k = p.diagonal[i] + 1; k < end && p.column[k] < p.rows; ++k, block += size)
      subtract_product<n>(block, part(p.column[k]), sum);
    column<n>(x, i) = -((sum[0] + sum[1]) + (sum[2] + sum[3]));
    Vector solved[4] = {};
    subtract_product<n>(block, part(i), solved);
    block += size;
    const Vector value = (solved[0] + solved[1]) + (solved[2] + solved[3]);
    column<n>(x, i) = value;
    column<n>(z, i) = __builtin_convertvector(value, Column<double, n>);
  }
}

} // namespace

const BlockKernels<4> block_kernels_4{
    multiply<4>, copy_fourth_rows<4>, fourth_row_defect<4>, factor<4>, pack<4>, solve<4>};
const BlockKernels<8> block_kernels_8{
    multiply<8>, copy_fourth_rows<8>, fourth_row_defect<8>, factor<8>, pack<8>, solve<8>};

} // namespace drogue::la::DROGUE_ISA
