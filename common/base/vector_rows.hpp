// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>

/// For kernels alone, which are compiled once for each instruction set (drogue_kernels in
/// cmake/targets.cmake): the inline namespace keeps what they define apart.
namespace drogue {
inline namespace DROGUE_ISA {

/// Values side by side, readable at any address.
template <int lanes>
struct RowOf {
  using type __attribute__((vector_size(sizeof(double) * lanes), aligned(sizeof(double)), may_alias)) =
      double;
};
template <int lanes>
using Row = typename RowOf<lanes>::type;

/// Row i of x {n, lanes}.
template <int lanes>
inline const Row<lanes>& row_of(const double* x, std::int32_t i) noexcept {
  return *reinterpret_cast<const Row<lanes>*>(x + static_cast<std::ptrdiff_t>(i) * lanes);
}
template <int lanes>
inline Row<lanes>& row_of(double* x, std::int32_t i) noexcept {
  return *reinterpret_cast<Row<lanes>*>(x + static_cast<std::ptrdiff_t>(i) * lanes);
}

} // namespace DROGUE_ISA
} // namespace drogue
