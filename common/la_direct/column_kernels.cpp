// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once for each instruction set: drogue_kernels in cmake/targets.cmake.
#include "common/la_direct/column_kernels.hpp"

#include <cstddef>
#include <type_traits>

#include "common/base/vector_rows.hpp"

namespace drogue::la::DROGUE_ISA {
namespace {

/// Values of the block on the diagonal of a group.
constexpr int triangle(int width) {
  return width * (width + 1) / 2;
}

/// A group of columns, from k on.
struct Group {
  std::int32_t k = 0;
  const double* value = nullptr;
  const std::int32_t *row = nullptr, *end = nullptr;
};

template <int lanes, int width>
void forward(const Group& g, double* y) noexcept {
  Row<lanes> z[width];
  for (int i = 0; i < width; ++i) z[i] = row_of<lanes>(y, g.k + i);
  const double* L = g.value;
  for (int i = 0; i < width; ++i) {
    z[i] *= *L++;
    for (int j = i + 1; j < width; ++j) z[j] -= *L++ * z[i];
    row_of<lanes>(y, g.k + i) = z[i];
  }
  for (const std::int32_t* row = g.row; row < g.end; ++row, L += width) {
    Row<lanes> sum = L[0] * z[0];
    for (int i = 1; i < width; ++i) sum += L[i] * z[i];
    row_of<lanes>(y, *row) -= sum;
  }
}

template <int lanes, int width>
void backward(const Group& g, double* y) noexcept {
  Row<lanes> z[width];
  for (int i = 0; i < width; ++i) z[i] = row_of<lanes>(y, g.k + i);
  const double* L = g.value + triangle(width);
  for (const std::int32_t* row = g.row; row < g.end; ++row, L += width) {
    const Row<lanes> value = row_of<lanes>(y, *row);
    for (int i = 0; i < width; ++i) z[i] -= L[i] * value;
  }
  L = g.value + triangle(width);
  for (int i = width - 1; i >= 0; --i) {
    L -= width - i;
    for (int j = i + 1; j < width; ++j) z[i] -= L[j - i] * z[j];
    z[i] *= L[0];
    row_of<lanes>(y, g.k + i) = z[i];
  }
}

/// Calls visit(std::integral_constant<int, width>{}), so that kernels know the width when compiled.
template <class Visit, int width = 1>
void with_width(std::int32_t wanted, Visit&& visit) {
  if constexpr (width < most_columns_together) {
    if (wanted != width) return with_width<Visit, width + 1>(wanted, static_cast<Visit&&>(visit));
  }
  visit(std::integral_constant<int, width>{});
}

template <int lanes>
void solve(const GroupedFactor& f, double* y) noexcept {
  const auto groups = static_cast<std::int32_t>(f.group.size()) - 1;
  const auto width = [&f](std::int32_t g) {
    return f.group[static_cast<std::size_t>(g) + 1] - f.group[static_cast<std::size_t>(g)];
  };
  const auto group_at = [&f](std::int32_t g, const double* value) {
    const auto i = static_cast<std::size_t>(g);
    return Group{f.group[i], value, f.row.data() + f.first_row[i], f.row.data() + f.first_row[i + 1]};
  };
  const auto size = [&](std::int32_t g) {
    const auto i = static_cast<std::size_t>(g);
    return triangle(width(g)) + static_cast<std::ptrdiff_t>(width(g)) * (f.first_row[i + 1] - f.first_row[i]);
  };
  const double* value = f.value.data();
  for (std::int32_t g = 0; g < groups; value += size(g), ++g)
    with_width(width(g), [&](auto w) { forward<lanes, w>(group_at(g, value), y); });
  for (std::int32_t g = groups - 1; g >= 0; --g) {
    value -= size(g);
    with_width(width(g), [&](auto w) { backward<lanes, w>(group_at(g, value), y); });
  }
}

} // namespace

const ColumnKernels column_kernels{solve<4>, solve<8>};

} // namespace drogue::la::DROGUE_ISA
