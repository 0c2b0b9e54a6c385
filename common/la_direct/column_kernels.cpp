// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once for each instruction set: drogue_kernels in cmake/targets.cmake.
#include "common/la_direct/column_kernels.hpp"

#include <cstddef>
#include <type_traits>

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

/// Calls visit(std::integral_constant<int, width>{}), so that kernels know the width when compiled.
template <class Visit>
void with_width(std::int32_t width, Visit&& visit) {
  static_assert(most_columns_together == 4);
  switch (width) {
  case 1:
    return visit(std::integral_constant<int, 1>{});
  case 2:
    return visit(std::integral_constant<int, 2>{});
  case 3:
    return visit(std::integral_constant<int, 3>{});
  default:
    return visit(std::integral_constant<int, 4>{});
  }
}

template <int lanes>
void solve(const FactorColumns& f, double* y) noexcept {
  const auto width = [&](std::int32_t g) { return f.group[g + 1] - f.group[g]; };
  for (std::int32_t g = 0; g < f.groups; ++g)
    with_width(width(g), [&](auto w) { forward<lanes, w>(f, f.group[g], y); });
  for (std::int32_t g = f.groups - 1; g >= 0; --g)
    with_width(width(g), [&](auto w) { backward<lanes, w>(f, f.group[g], y); });
}

} // namespace

const ColumnKernels column_kernels{solve<4>, solve<8>};

} // namespace drogue::la::DROGUE_ISA
