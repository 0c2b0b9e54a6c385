// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "fluid_solver/kernel_isa.hpp"

/// Numbers of the element kernels: double, or eight elements at a time.
namespace drogue::fluid {
inline namespace DROGUE_ISA {

/// Eight doubles, one a lane: eight elements assembled at once. Compilers split it where registers are
/// shorter.
using Batch = double __attribute__((vector_size(64)));
inline constexpr int batch_size = 8;

/// Applies a function of double lane by lane.
template <class Real, class Function>
[[nodiscard]] inline Real lanewise(Real a, Function f) noexcept {
  if constexpr (std::is_same_v<Real, double>) {
    return f(a);
  } else {
    Real r;
    for (int l = 0; l < batch_size; ++l) r[l] = f(a[l]);
    return r;
  }
}

template <class Real>
[[nodiscard]] inline Real square_root(Real a) noexcept {
  return lanewise(a, [](double v) noexcept { return std::sqrt(v); });
}
template <class Real>
[[nodiscard]] inline Real cube_root(Real a) noexcept {
  return lanewise(a, [](double v) noexcept { return std::cbrt(v); });
}
template <class Real>
[[nodiscard]] inline Real absolute(Real a) noexcept {
  return lanewise(a, [](double v) noexcept { return std::fabs(v); });
}
template <class Real>
[[nodiscard]] inline Real larger(Real a, Real b) noexcept {
  return a > b ? a : b;
}

} // namespace DROGUE_ISA
} // namespace drogue::fluid
