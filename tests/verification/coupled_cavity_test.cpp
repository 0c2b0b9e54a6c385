// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/verify.hpp"
#include "tests/verification/coupled_run.hpp"
#include "tests/verification/flexible_cavity.hpp"

namespace drogue::test {
namespace {

constexpr double period = 5;

struct Answer {
  CoupledRun run;
  std::vector<double> t, y; ///< of the middle
};

Answer run(const std::string& name, const Cavity& c) {
  const auto folder = fresh_folder(name);
  write_case(folder, c);
  CoupledRun coupled = run_coupled(folder, std::chrono::minutes(240));
  const Table probe = read_csv(folder / "run/structure/probes.csv");
  return {std::move(coupled), column(probe, "time"), column(probe, "middle_y")};
}

/// Where the displacement turns, by parabolas through the samples.
void print_extremes(const Answer& a, double until) {
  for (std::size_t i = 1; i + 1 < a.y.size() && a.t[i] < until; ++i) {
    const double before = a.y[i - 1], here = a.y[i], after = a.y[i + 1];
    if ((here - before) * (after - here) > 0) continue;
    const double shift = 0.5 * (before - after) / (before - 2 * here + after);
    fmt::print("  {} {:.4f} at t = {:.2f}\n", here > before ? "max" : "min",
               here - 0.25 * (before - after) * shift, a.t[i] + shift * (a.t[i] - a.t[i - 1]));
  }
}

/// The bands of the published runs of this definition, each +- 5 %, over the last period.
void verify_periodic(const std::string& name, const Cavity& c) {
  const Answer a = run(name, c);
  print_extremes(a, 25);
  const auto samples = static_cast<std::size_t>(std::lround(period / c.time_step));
  ASSERT_GE(a.y.size(), samples);
  const auto first = a.y.end() - static_cast<std::ptrdiff_t>(samples);
  double mean = 0;
  for (auto y = first; y != a.y.end(); ++y) mean += *y / static_cast<double>(samples);
  const std::string id = "coupler/" + name;
  verify_between(id, "peak", *std::max_element(first, a.y.end()), 0.95 * 0.2619, 1.05 * 0.2769);
  verify_between(id, "trough", *std::min_element(first, a.y.end()), 0.95 * 0.1967, 1.05 * 0.2033);
  verify_between(id, "mean", mean, 0.95 * 0.2316, 1.05 * 0.2466);
  verify_between(id, "iterations_iqn_ils", a.run.mean_iterations(), 0, 6);
}

TEST(FlexibleCavity, IsPeriodicWith16Cells) {
  verify_periodic("flexible_cavity_16", {.cells = 16});
}

TEST(FlexibleCavity, IsPeriodicWith32Cells) {
  verify_periodic("flexible_cavity_32", {});
}

TEST(FlexibleCavity, IsPeriodicWith32CellsInHalfTheStep) {
  verify_periodic("flexible_cavity_32_half_step", {.time_step = 0.05});
}

TEST(FlexibleCavity, ByAitken) {
  const Answer a = run("aitken", {.end = 20, .acceleration = "method: AITKEN relaxation: 0.5"});
  verify_between("coupler/flexible_cavity_32", "iterations_aitken", a.run.mean_iterations(), 0, 12);
}

} // namespace
} // namespace drogue::test
