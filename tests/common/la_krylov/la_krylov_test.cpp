// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "common/la_krylov/block_matrix.hpp"
#include "common/la_krylov/krylov_solver.hpp"
#include "common/la_krylov/node_graph.hpp"
#include "common/la_krylov/poisson_amg.hpp"
#include "common/la_krylov/session.hpp"

namespace drogue::la {
namespace {

/// A chain of n nodes, joined in a shuffled order.
NodeGraph shuffled_chain(std::int32_t n) {
  std::vector<std::int32_t> name(static_cast<std::size_t>(n));
  std::iota(name.begin(), name.end(), 0);
  std::shuffle(name.begin(), name.end(), std::mt19937(1));
  std::vector<std::int32_t> edges;
  for (std::size_t i = 0; i + 1 < name.size(); ++i) {
    edges.push_back(name[i]);
    edges.push_back(name[i + 1]);
  }
  return node_graph(n, edges, 2);
}

NodeGraph chain(std::int32_t n) {
  std::vector<std::int32_t> edges;
  for (std::int32_t i = 0; i + 1 < n; ++i) {
    edges.push_back(i);
    edges.push_back(i + 1);
  }
  return node_graph(n, edges, 2);
}

TEST(NodeGraph, ReverseCuthillMckeeRestoresTheChain) {
  const NodeGraph graph = shuffled_chain(50);
  const auto order = reverse_cuthill_mckee(graph);
  ASSERT_EQ(order.size(), 50U);
  for (std::size_t i = 0; i + 1 < order.size(); ++i) { // neighbours in the order are neighbours in the graph
    const auto row = graph.row(order[i]);
    EXPECT_NE(std::find(row.begin(), row.end(), order[i + 1]), row.end());
  }
}

TEST(NodeGraph, PartsCoverAllRows) {
  const NodeGraph graph = chain(101);
  const auto parts = partition_rows(graph, 4);
  EXPECT_EQ(parts.front().first, 0);
  EXPECT_EQ(parts.back().last, 101);
  for (std::size_t p = 0; p + 1 < parts.size(); ++p) EXPECT_EQ(parts[p].last, parts[p + 1].first);
  for (const RowRange& part : parts) EXPECT_NEAR(part.size(), 25, 2);
}

/// Block-tridiagonal and diagonally dominant.
template <int n>
void fill(BlockMatrix<n>& A) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<float> uniform(-1, 1);
  const LocalPattern& p = A.pattern();
  for (std::int32_t k = 0; k < p.row_start.back(); ++k)
    for (int q = 0; q < n * n; ++q) A.block(k)[q] = uniform(generator);
  for (std::int32_t i = 0; i < p.rows; ++i)
    for (int q = 0; q < n; ++q) A.block(p.diagonal[static_cast<std::size_t>(i)])[q * n + q] += 3.0F * n;
}

template <int n>
void expect_ilu_is_exact_without_fill(const RowRange& own) {
  const NodeGraph graph = chain(30);
  const LocalPattern pattern = local_pattern(graph, own);
  BlockMatrix<n> A(pattern);
  fill(A);
  BlockIlu<n> ilu(pattern);
  ASSERT_FALSE(ilu.factor(A).has_value());
  std::vector<double> x(static_cast<std::size_t>(pattern.columns()) * n, 0.0); // ghosts are left out: zero
  const std::size_t size = static_cast<std::size_t>(pattern.rows) * n;
  for (std::size_t i = 0; i < size; ++i) x[i] = std::sin(1.0 + static_cast<double>(i));
  std::vector<double> b(size);
  std::vector<double> z(size);
  A.multiply(x.data(), b.data());
  ilu.apply(b.data(), z.data());
  for (std::size_t i = 0; i < size; ++i) EXPECT_NEAR(z[i], x[i], 1e-2); // 8 bits of mantissa
}

TEST(BlockIlu, IsExactForABlockTridiagonalMatrix) {
  expect_ilu_is_exact_without_fill<4>({0, 30});
  expect_ilu_is_exact_without_fill<8>({0, 30});
}

TEST(BlockIlu, LeavesTheGhostsOfARankOut) {
  expect_ilu_is_exact_without_fill<4>({10, 19});
  expect_ilu_is_exact_without_fill<8>({10, 19});
}

TEST(BlockIlu, NamesTheRowOfASingularPivot) {
  const LocalPattern pattern = local_pattern(chain(5), {0, 5});
  BlockMatrix<4> A(pattern);
  for (std::int32_t i = 0; i < 5; ++i)
    if (i != 3)
      for (int q = 0; q < 4; ++q) A.set_identity_row(i, q);
  BlockIlu<4> ilu(pattern);
  EXPECT_EQ(ilu.factor(A), 3);
}

TEST(FourthRows, DefectOfTheFourthRowsIsThatOfTheProduct) {
  const LocalPattern pattern = local_pattern(chain(6), {0, 6});
  BlockMatrix<8> A(pattern);
  fill(A);
  std::vector<double> x(48, 0.5);
  std::vector<double> r(48, 2.0);
  std::vector<double> y(48);
  std::vector<double> defect(12);
  A.multiply(x.data(), y.data());
  FourthRows<8> rows(pattern);
  rows.copy(A);
  rows.defect(r.data(), x.data(), defect.data());
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t q = 0; q < 2; ++q) EXPECT_NEAR(defect[2 * i + q], 2.0 - y[8 * i + 4 * q + 3], 1e-12);
}

TEST(KrylovSolver, SaysHonestlyWhetherItConverged) {
  const std::size_t n = 40; // the one-dimensional Laplacian
  const auto laplace = [n](std::span<const double> in, std::span<double> out) {
    for (std::size_t i = 0; i < n; ++i)
      out[i] = 2 * in[i] - (i > 0 ? in[i - 1] : 0) - (i + 1 < n ? in[i + 1] : 0);
  };
  const auto identity = [](std::span<const double> in, std::span<double> out) {
    std::copy(in.begin(), in.end(), out.begin());
  };
  const std::vector<double> b(n, 1.0);
  std::vector<double> x(n);
  for (const auto& [limit, converges] : {std::pair{100, true}, std::pair{3, false}}) {
    auto solver = KrylovSolver::create(static_cast<std::int32_t>(n), laplace, identity, {1e-10, limit, 60});
    ASSERT_TRUE(solver.ok());
    const auto outcome = solver->solve(b, x);
    ASSERT_TRUE(outcome.ok());
    EXPECT_EQ(outcome->converged, converges);
    if (!converges) continue;
    for (std::size_t i = 0; i < n; ++i) // exact: (i+1)(n-i)/2
      EXPECT_NEAR(x[i], 0.5 * static_cast<double>((i + 1) * (n - i)), 1e-6);
  }
}

/// Preconditioned by one cycle, the seven-point Laplacian of a 15^3 grid takes few iterations; alone it takes
/// many.
TEST(PoissonAmg, OneCycleIsAGoodPreconditioner) {
  constexpr std::int32_t m = 15;
  constexpr std::int32_t n = m * m * m;
  std::vector<std::int32_t> edges;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t at[3] = {i % m, i / m % m, i / (m * m)};
    const std::int32_t step[3] = {1, m, m * m};
    for (int d = 0; d < 3; ++d)
      if (at[d] + 1 < m) edges.insert(edges.end(), {i, i + step[d]});
  }
  const RowRange own{0, n};
  const LocalPattern pattern = local_pattern(node_graph(n, edges, 2), own);
  std::vector<double> values(pattern.column.size(), -1.0);
  for (const std::int32_t k : pattern.diagonal) values[static_cast<std::size_t>(k)] = 6.0;
  auto amg = PoissonAmg::create(pattern, own, values);
  ASSERT_TRUE(amg.ok());
  const auto multiply = [&](std::span<const double> in, std::span<double> out) {
    for (std::size_t i = 0; i < in.size(); ++i) {
      out[i] = 0;
      for (std::int32_t k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k)
        out[i] += values[static_cast<std::size_t>(k)] *
                  in[static_cast<std::size_t>(pattern.column[static_cast<std::size_t>(k)])];
    }
  };
  const auto cycle = [&](std::span<const double> in, std::span<double> out) {
    EXPECT_TRUE(amg->apply(in, out));
  };
  const auto copy = [](std::span<const double> in, std::span<double> out) {
    std::copy(in.begin(), in.end(), out.begin());
  };
  std::vector<double> b(static_cast<std::size_t>(n));
  for (std::size_t i = 0; i < b.size(); ++i) b[i] = std::sin(static_cast<double>(i));
  std::vector<double> x(b.size());
  const auto iterations = [&](const KrylovSolver::Apply& preconditioner) {
    auto solver = KrylovSolver::create(n, multiply, preconditioner, {1e-8, 200, 100});
    EXPECT_TRUE(solver.ok());
    const auto outcome = solver->solve(b, x);
    EXPECT_TRUE(outcome.ok() && outcome->converged);
    return outcome->iterations;
  };
  EXPECT_LE(iterations(cycle), 14);
  EXPECT_GE(iterations(copy), 28);
}

} // namespace
} // namespace drogue::la
