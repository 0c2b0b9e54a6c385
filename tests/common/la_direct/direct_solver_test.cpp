// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/la_direct/direct_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <cmath>
#include <vector>

namespace drogue::la {
namespace {

/// Five-point Laplacian on an n x n grid, plus `shift` on the diagonal and `skew` between left and right
/// neighbours.
SparseMatrix grid_matrix(int n, double shift, double skew = 0) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto index = [n](int i, int j) { return i * n + j; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      entries.emplace_back(index(i, j), index(i, j), 4 + shift);
      if (j + 1 < n) {
        entries.emplace_back(index(i, j), index(i, j + 1), -1 + skew);
        entries.emplace_back(index(i, j + 1), index(i, j), -1 - skew);
      }
      if (i + 1 < n) {
        entries.emplace_back(index(i, j), index(i + 1, j), -1);
        entries.emplace_back(index(i + 1, j), index(i, j), -1);
      }
    }
  SparseMatrix A(n * n, n * n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

Eigen::MatrixXd solution(Eigen::Index rows, int columns) {
  Eigen::MatrixXd x(rows, columns);
  for (Eigen::Index i = 0; i < x.size(); ++i) x.data()[i] = std::sin(1.0 + static_cast<double>(i * i % 97));
  return x;
}

std::span<const double> read(const Eigen::MatrixXd& m) {
  return {m.data(), static_cast<std::size_t>(m.size())};
}
std::span<double> write(Eigen::MatrixXd& m) {
  return {m.data(), static_cast<std::size_t>(m.size())};
}

template <class Solver>
void expect_factors(Solver& solver, const SparseMatrix& A, bool expected) {
  const auto factored = solver.factor(A);
  ASSERT_TRUE(factored.ok()) << factored.error().message;
  ASSERT_EQ(*factored, expected);
}

TEST(CholeskySolver, SolvesForSeveralRightHandSides) {
  const SparseMatrix A = grid_matrix(20, 0.1);
  const Eigen::MatrixXd expected = solution(400, 3);
  const Eigen::MatrixXd b = A * expected;
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(400, 3);
  CholeskySolver solver;
  expect_factors(solver, A, true);
  ASSERT_TRUE(solver.solve(read(b), write(x), 3).ok());
  EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm());
}

TEST(CholeskySolver, SolvesInPlaceAndReusesThePattern) {
  CholeskySolver solver;
  for (const double shift : {0.1, 3.0, 0.5}) {
    const SparseMatrix A = grid_matrix(15, shift);
    const Eigen::MatrixXd expected = solution(225, 1);
    Eigen::MatrixXd x = A * expected;
    expect_factors(solver, A, true);
    ASSERT_TRUE(solver.solve(read(x), write(x)).ok());
    EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm()) << shift;
  }
}

/// By columns: more right-hand sides than it takes at once, in place, and after a second factorisation of the
/// pattern.
TEST(CholeskySolver, ManySolutionsAgreeWithTheSupernodes) {
  CholeskySolver solver(CholeskySolver::Use::many_solutions);
  for (const double shift : {0.1, 2.0}) {
    const SparseMatrix A = grid_matrix(20, shift);
    const Eigen::MatrixXd expected = solution(400, 11);
    Eigen::MatrixXd x = A * expected;
    expect_factors(solver, A, true);
    ASSERT_TRUE(solver.solve(read(x), write(x), 11).ok());
    EXPECT_LT((x - expected).norm(), 1e-11 * expected.norm());
  }
  CholeskySolver indefinite(CholeskySolver::Use::many_solutions);
  expect_factors(indefinite, grid_matrix(20, -5), false);
}

TEST(CholeskySolver, SaysWhenTheMatrixIsNotPositiveDefinite) {
  CholeskySolver solver;
  expect_factors(solver, grid_matrix(10, -4.5), false);
  expect_factors(solver, grid_matrix(10, 0), true);
}

TEST(CholeskySolver, TakesAnotherPatternAfterForgetting) {
  CholeskySolver solver;
  expect_factors(solver, grid_matrix(10, 0.1), true);
  solver.forget_pattern();
  const SparseMatrix A = grid_matrix(12, 0.1);
  const Eigen::MatrixXd expected = solution(144, 1);
  Eigen::MatrixXd x = A * expected;
  expect_factors(solver, A, true);
  ASSERT_TRUE(solver.solve(read(x), write(x)).ok());
  EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm());
}

TEST(LuSolver, SolvesUnsymmetricMatrices) {
  LuSolver solver;
  for (const double skew : {0.3, 0.9}) {
    const SparseMatrix A = grid_matrix(20, 0.1, skew);
    const Eigen::MatrixXd expected = solution(400, 1);
    const Eigen::MatrixXd b = A * expected;
    Eigen::MatrixXd x = Eigen::MatrixXd::Zero(400, 1);
    expect_factors(solver, A, true);
    ASSERT_TRUE(solver.solve(read(b), write(x)).ok());
    EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm()) << skew;
  }
}

/// A saddle point (zero block on the diagonal) needs pivoting.
TEST(LuSolver, SolvesASaddlePoint) {
  SparseMatrix A(3, 3);
  const std::vector<Eigen::Triplet<double>> entries = {{0, 0, 2},  {0, 2, 1}, {1, 1, 3},
                                                       {1, 2, -1}, {2, 0, 1}, {2, 1, -1}};
  A.setFromTriplets(entries.begin(), entries.end());
  const Eigen::MatrixXd expected = solution(3, 1);
  const Eigen::MatrixXd b = A * expected;
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(3, 1);
  LuSolver solver;
  expect_factors(solver, A, true);
  ASSERT_TRUE(solver.solve(read(b), write(x)).ok());
  EXPECT_LT((x - expected).norm(), 1e-14);
}

TEST(LuSolver, SaysWhenTheMatrixIsSingular) {
  SparseMatrix A(3, 3);
  const std::vector<Eigen::Triplet<double>> entries = {{0, 0, 1}, {0, 1, 2}, {1, 0, 2}, {1, 1, 4}, {2, 2, 1}};
  A.setFromTriplets(entries.begin(), entries.end());
  LuSolver solver;
  expect_factors(solver, A, false);
}

} // namespace
} // namespace drogue::la
