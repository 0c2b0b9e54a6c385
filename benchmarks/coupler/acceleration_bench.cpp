// SPDX-License-Identifier: GPL-3.0-or-later
//
// An iteration of IQN-ILS with 36 columns kept, on 20,000 nodes with their velocities as passengers.
// preCICE 3.4.1 takes 51 to 110 ms for it on such a surface.
#include <benchmark/benchmark.h>

#include <cmath>

#include "coupler/acceleration/iqn_ils.hpp"

namespace drogue::acceleration {
namespace {

void iqn_ils(benchmark::State& state) {
  constexpr std::size_t n = 60000;
  Settings settings;
  settings.max_columns = 36;
  settings.reuse_steps = 1000;
  settings.filter = 1e-12;
  IqnIls iqn(settings, std::vector<double>(n, 1.0), n, n);
  std::vector<double> x(n), h(n), p(n), next(n), p_next(n);
  int k = 0;
  const auto iterate = [&] { // no pattern: every column is kept
    ++k;
    for (std::size_t i = 0; i < n; ++i) {
      x[i] = std::sin(0.37 * k + 0.0011 * static_cast<double>(i) * k);
      h[i] = 0.7 * x[i] + std::cos(0.0007 * static_cast<double>(i) * k);
    }
  };
  iqn.begin_step();
  for (int i = 0; i < 40; ++i) {
    iterate();
    if (!iqn.next({x, h, p, p}, next, p_next)) state.SkipWithError("no update");
  }
  for (auto _ : state) {
    state.PauseTiming();
    iterate();
    state.ResumeTiming();
    if (!iqn.next({x, h, p, p}, next, p_next)) state.SkipWithError("no update");
  }
  state.SetLabel("preCICE: 51-110 ms");
}
BENCHMARK(iqn_ils)->Name("iqn_ils/20k_36_columns")->Unit(benchmark::kMillisecond);

} // namespace
} // namespace drogue::acceleration
