// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "fluid_solver/kernel_isa.hpp"

/// Numbers of the element kernels: double, or eight or sixteen elements at a time.
namespace drogue::fluid {
inline namespace DROGUE_ISA {

/// Eight doubles, one a lane: eight elements assembled at once. Compilers split it where registers are
/// shorter.
using Batch = double __attribute__((vector_size(64)));
inline constexpr int batch_size = 8;

/// Sixteen floats: two batches side by side. The matrix is kept in single precision; its tangents are formed
/// in it, from quantities that were evaluated in double precision.
using Floats = float __attribute__((vector_size(64)));

/// What a constant must be to be multiplied by a Real.
template <class Real>
using Scalar = std::conditional_t<std::is_same_v<Real, Floats>, float, double>;

/// Members of `from`, a struct of Batches, to half 0 or 1 of those of `to`, the same struct of Floats.
template <class From, class To>
inline void narrow(const From& from, int half, To& to) noexcept {
  static_assert(sizeof(From) == sizeof(To) && sizeof(From) % sizeof(Batch) == 0);
  using Half = float __attribute__((vector_size(32)));
  for (std::size_t at = 0; at < sizeof(From); at += sizeof(Batch)) {
    Batch wide;
    std::memcpy(&wide, reinterpret_cast<const char*>(&from) + at, sizeof(wide));
    const Half values = __builtin_convertvector(wide, Half);
    std::memcpy(reinterpret_cast<char*>(&to) + at + sizeof(Half) * static_cast<std::size_t>(half), &values,
                sizeof(values));
  }
}

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
    using Eight = float __attribute__((vector_size(32)));
    Eight y = __builtin_convertvector(a, Eight);
    Bits bits;
    std::memcpy(&bits, &y, sizeof(bits));
    bits = bits / 3 + 0x2a5137a0;
    std::memcpy(&y, &bits, sizeof(y));
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
