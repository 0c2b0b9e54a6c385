// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once for each instruction set: drogue_kernels in cmake/targets.cmake.
#include "common/la_direct/column_kernels.hpp"

#include <cstddef>

namespace drogue::la::DROGUE_ISA {
namespace {

/// Values side by side, readable at any address.
template <int lanes>
struct RowOf {
  using type __attribute__((vector_size(sizeof(double) * lanes), aligned(sizeof(double)), may_alias)) =
      double;
};
template <int lanes>
using Row = typename RowOf<lanes>::type;

template <int lanes>
Row<lanes>& row_of(double* y, std::int32_t i) {
  return *reinterpret_cast<Row<lanes>*>(y + static_cast<std::ptrdiff_t>(i) * lanes);
}

/// Columns k to k + width: pointers to their diagonals, and the rows that all of them have.
template <int width>
struct Together {
  const double* diagonal[width];
  const std::int32_t* row;
  std::int32_t rows;
  Together(const FactorColumns& f, std::int32_t k) {
    for (int i = 0; i < width; ++i) diagonal[i] = f.L + f.first[k + i];
    row = f.row + f.first[k + width - 1] + 1;
    rows = f.count[k + width - 1] - 1;
  }
  /// Entry of column i in the common row r.
  [[nodiscard]] double below(int i, std::int32_t r) const { return diagonal[i][width - i + r]; }
};

template <int lanes, int width>
void forward(const FactorColumns& f, std::int32_t k, double* y) noexcept {
  const Together<width> t(f, k);
  Row<lanes> z[width];
  for (int i = 0; i < width; ++i) z[i] = row_of<lanes>(y, k + i);
  for (int i = 0; i < width; ++i) {
    z[i] /= t.diagonal[i][0];
    for (int j = i + 1; j < width; ++j) z[j] -= t.diagonal[i][j - i] * z[i];
    row_of<lanes>(y, k + i) = z[i];
  }
  for (std::int32_t r = 0; r < t.rows; ++r) {
    Row<lanes> sum = t.below(0, r) * z[0];
    for (int i = 1; i < width; ++i) sum += t.below(i, r) * z[i];
    row_of<lanes>(y, t.row[r]) -= sum;
  }
}

template <int lanes, int width>
void backward(const FactorColumns& f, std::int32_t k, double* y) noexcept {
  const Together<width> t(f, k);
  Row<lanes> z[width];
  for (int i = 0; i < width; ++i) z[i] = row_of<lanes>(y, k + i);
  for (std::int32_t r = 0; r < t.rows; ++r) {
    const Row<lanes> value = row_of<lanes>(y, t.row[r]);
    for (int i = 0; i < width; ++i) z[i] -= t.below(i, r) * value;
  }
  for (int i = width - 1; i >= 0; --i) {
    for (int j = i + 1; j < width; ++j) z[i] -= t.diagonal[i][j - i] * z[j];
    z[i] /= t.diagonal[i][0];
    row_of<lanes>(y, k + i) = z[i];
  }
}

template <int lanes>
void solve(const FactorColumns& f, double* y) noexcept {
  static_assert(most_columns_together == 4);
  for (std::int32_t g = 0; g < f.groups; ++g) switch (f.group[g + 1] - f.group[g]) {
    case 1:
      forward<lanes, 1>(f, f.group[g], y);
      break;
    case 2:
      forward<lanes, 2>(f, f.group[g], y);
      break;
    case 3:
      forward<lanes, 3>(f, f.group[g], y);
      break;
    default:
      forward<lanes, 4>(f, f.group[g], y);
    }
  for (std::int32_t g = f.groups - 1; g >= 0; --g) switch (f.group[g + 1] - f.group[g]) {
    case 1:
      backward<lanes, 1>(f, f.group[g], y);
      break;
    case 2:
      backward<lanes, 2>(f, f.group[g], y);
      break;
    case 3:
      backward<lanes, 3>(f, f.group[g], y);
      break;
    default:
      backward<lanes, 4>(f, f.group[g], y);
    }
}

} // namespace

const ColumnKernels column_kernels{solve<4>, solve<8>};

} // namespace drogue::la::DROGUE_ISA
