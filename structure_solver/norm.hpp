// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <span>

namespace drogue::structure {

/// sqrt(sum x_i^2), summed one after the other: the same bits wherever the array lies in memory.
[[nodiscard]] inline double norm(std::span<const double> x) noexcept {
  double sum = 0;
  for (const double value : x) sum += value * value;
  return std::sqrt(sum);
}

} // namespace drogue::structure
