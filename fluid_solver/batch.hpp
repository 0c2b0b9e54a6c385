// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
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
/// Cube root of positive numbers.
template <class Real>
[[nodiscard]] inline Real cube_root(Real a) noexcept {
  if constexpr (std::is_same_v<Real, Batch>) {
    // A third of the exponent, as integers, is within 6 %; Halley's iteration cubes the error.
    using Bits = std::int32_t __attribute__((vector_size(32)));
    using Floats = float __attribute__((vector_size(32)));
    Floats y;
    const Floats narrow = __builtin_convertvector(a, Floats);
    Bits bits;
    __builtin_memcpy(&bits, &narrow, sizeof(bits));
    bits = bits / 3 + 0x2a5137a0;
    __builtin_memcpy(&y, &bits, sizeof(y));
    Batch root = __builtin_convertvector(y, Batch);
    for (int k = 0; k < 3; ++k) {
      const Batch cube = root * root * root;
      root *= (cube + 2.0 * a) / (2.0 * cube + a);
    }
    return root;
  } else {
    return lanewise(a, [](double v) noexcept { return std::cbrt(v); });
  }
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
