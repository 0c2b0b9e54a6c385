// SPDX-License-Identifier: GPL-3.0-or-later
#include "benchmarks/fluid/machine.hpp"

#include <vector>

#include "benchmarks/support/measure.hpp"
#include "common/base/isa.hpp"

namespace drogue::bench {
namespace {

using Eight = double __attribute__((vector_size(64)));
constexpr int chains = 12;
constexpr long rounds = 4'000'000;

/// Twelve chains of multiply-adds hide each other's latency.
#define DROGUE_CHAINS                                                                                        \
  Eight sum[chains] = {};                                                                                    \
  Eight factor{};                                                                                            \
  for (int l = 0; l < 8; ++l) factor[l] = 0.999 + 1e-5 * l;                                                  \
  for (long k = 0; k < rounds; ++k)                                                                          \
    for (auto& s : sum) s = s * factor + factor;                                                             \
  double total = 0;                                                                                          \
  for (const auto& s : sum) total += s[0] + s[7];                                                            \
  return total;

[[gnu::target("avx512f")]] double chains_avx512() {
  DROGUE_CHAINS
}
[[gnu::target("avx2,fma")]] double chains_avx2() {
  DROGUE_CHAINS
}
double chains_baseline() {
  DROGUE_CHAINS
}
#undef DROGUE_CHAINS

} // namespace

double memory_bandwidth() {
  constexpr std::size_t n = 12'000'000; // 3 x 96 MB
  std::vector<double> a(n, 0.0), b(n, 1.0), c(n, 2.0);
  volatile double sink = 0;
  const double time = least_processor_time(6, [&] {
    for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + 0.5 * c[i];
    sink = a[n / 2];
  });
  return 24.0 * n / time;
}

double arithmetic_peak() {
  volatile double sink = 0;
  const double time = least_processor_time(4, [&] {
    sink = best_isa() == Isa::avx512 ? chains_avx512()
           : best_isa() == Isa::avx2 ? chains_avx2()
                                     : chains_baseline();
  });
  return 2.0 * 8 * chains * rounds / time;
}

} // namespace drogue::bench
