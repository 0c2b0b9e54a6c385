// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <span>

namespace drogue::acceleration {

/// sum a_i b_i in an order that depends on the length alone (not on the memory's alignment).
[[nodiscard]] inline double dot(std::span<const double> a, std::span<const double> b) noexcept {
  double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
  const std::size_t n = a.size(), whole = n - n % 4;
  for (std::size_t i = 0; i < whole; i += 4) {
    s0 += a[i] * b[i];
    s1 += a[i + 1] * b[i + 1];
    s2 += a[i + 2] * b[i + 2];
    s3 += a[i + 3] * b[i + 3];
  }
  for (std::size_t i = whole; i < n; ++i) s0 += a[i] * b[i];
  return (s0 + s1) + (s2 + s3);
}

/// y += c x
inline void add_scaled(double c, std::span<const double> x, std::span<double> y) noexcept {
  for (std::size_t i = 0; i < x.size(); ++i) y[i] += c * x[i];
}

[[nodiscard]] inline bool all_finite(std::span<const double> a) noexcept {
  for (const double v : a)
    if (!std::isfinite(v)) return false;
  return true;
}

} // namespace drogue::acceleration
