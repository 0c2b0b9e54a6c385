// SPDX-License-Identifier: GPL-3.0-or-later
//
// Direct solvers on a five-point Laplacian with the number of unknowns of the quick T-10 structure (some 100
// x 100).
#include <benchmark/benchmark.h>

#include <vector>

#include "common/la_direct/direct_solver.hpp"

namespace drogue::la {
namespace {

SparseMatrix laplacian(int n) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n * n; ++i) {
    entries.emplace_back(i, i, 4.1);
    if (i % n + 1 < n) entries.insert(entries.end(), {{i, i + 1, -1.0}, {i + 1, i, -1.0}});
    if (i + n < n * n) entries.insert(entries.end(), {{i, i + n, -1.0}, {i + n, i, -1.0}});
  }
  SparseMatrix A(n * n, n * n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

template <class Solver>
void factor(benchmark::State& state) {
  const SparseMatrix A = laplacian(100);
  Solver solver;
  for (auto _ : state)
    if (const auto factored = solver.factor(A); !factored || !*factored) state.SkipWithError("cannot factor");
}
BENCHMARK_TEMPLATE(factor, CholeskySolver)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(factor, LuSolver)->Unit(benchmark::kMillisecond);

void cholesky_solve(benchmark::State& state) {
  const SparseMatrix A = laplacian(100);
  std::vector<double> b(static_cast<std::size_t>(A.rows()), 1.0), x(b.size());
  CholeskySolver solver;
  if (const auto factored = solver.factor(A); !factored || !*factored) state.SkipWithError("cannot factor");
  for (auto _ : state)
    if (!solver.solve(b, x)) state.SkipWithError("cannot solve");
}
BENCHMARK(cholesky_solve)->Unit(benchmark::kMillisecond);

} // namespace
} // namespace drogue::la
