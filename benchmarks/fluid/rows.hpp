// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>

#include <fmt/format.h>

/// Rows as Google Benchmark's csv has them, and a clock.
namespace drogue::bench {

inline void row(const std::string& name, double value, const char* unit) {
  fmt::print("\"{}\",1,{:.6g},{:.6g},{}\n", name, value, value, unit);
  std::fflush(stdout);
}

template <class Function>
[[nodiscard]] double seconds(Function&& f) {
  const auto start = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

template <class Function>
[[nodiscard]] double least(int runs, Function&& f) {
  double best = INFINITY;
  for (int k = 0; k < runs; ++k) best = std::min(best, seconds(f));
  return best;
}

} // namespace drogue::bench
