// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "mesh_mover/linear_solver.hpp"
#include "mesh_mover/numbering.hpp"
#include "mesh_mover/stiffness.hpp"
#include "tests/mesh_mover/box_mesh.hpp"

namespace drogue::mesh_mover {
namespace {

using Vector = Eigen::VectorXd;

/// The stiffness of a graded cube, held at x0 in all components and on y0 in y alone.
struct Problem {
  mesh::Mesh mesh;
  Cells cells;
  Stiffness stiffness;

  explicit Problem(int n)
      : mesh(test::box_mesh({test::graded(1, n, 1.4), test::graded(1, n, 1.4), test::graded(1, n, 1.4)},
                            [](int, int, int) { return false; })),
        cells(cells_of(mesh)),
        stiffness(cells, mask(mesh)) {
    stiffness.assemble(pseudo_solid(0.3, 1, 1), mesh.points);
  }
  static Mask mask(const mesh::Mesh& mesh) {
    Mask given(static_cast<std::size_t>(mesh.node_count()), 0);
    for (const std::int32_t node : mesh.nodes_of("y0")) given[static_cast<std::size_t>(node)] = 2;
    for (const std::int32_t node : mesh.nodes_of("x0")) given[static_cast<std::size_t>(node)] = 7;
    return given;
  }
  [[nodiscard]] const SymmetricBlocks<double>& A() const { return stiffness.matrix(); }
  /// Whether an unknown, in the order of the rows, is given.
  [[nodiscard]] bool is_given(Eigen::Index i) const {
    return (stiffness.given_rows()[static_cast<std::size_t>(i / 3)] >> (i % 3) & 1) != 0;
  }
  [[nodiscard]] std::vector<double> positions() const {
    std::vector<double> by_row(mesh.points.size());
    stiffness.to_rows(mesh.points, by_row);
    return by_row;
  }
  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(3 * A().rows()); }
};

std::span<double> span_of(Vector& v) {
  return {v.data(), static_cast<std::size_t>(v.size())};
}

/// Some values between -1 and 1, always the same.
Vector some_vector(Eigen::Index n) {
  Vector v(n);
  for (Eigen::Index i = 0; i < n; ++i) v[i] = std::sin(12.9898 * static_cast<double>(i + 1));
  return v;
}

Eigen::MatrixXd dense(const SymmetricBlocks<double>& A) {
  const auto n = static_cast<Eigen::Index>(3 * A.rows());
  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t i = 0; i < A.rows(); ++i)
    for (std::size_t k = A.begin(i); k <= A.diagonal(i); ++k) {
      const auto row = static_cast<Eigen::Index>(3 * i);
      const Eigen::Index column = 3 * A.column[k];
      full.block<3, 3>(row, column) = A.block(k);
      full.block<3, 3>(column, row) = A.block(k).transpose();
    }
  return full;
}

Vector product(const SymmetricBlocks<double>& A, Vector x) {
  const RowParts parts(A, 1);
  Vector y(x.size());
  PartedProduct(A, parts).multiply(span_of(x), span_of(y));
  return y;
}

TEST(Stiffness, IsSymmetricPositiveDefiniteWithTheIdentityOnGivenComponents) {
  const Problem problem(2);
  const Eigen::MatrixXd full = dense(problem.A());
  EXPECT_TRUE(full.isApprox(full.transpose(), 1e-14));
  EXPECT_EQ(Eigen::LLT<Eigen::MatrixXd>(full).info(), Eigen::Success);
  for (Eigen::Index i = 0; i < problem.size(); ++i) {
    if (!problem.is_given(i)) continue;
    EXPECT_EQ(full(i, i), 1);
    EXPECT_EQ(full.row(i).norm(), 1);
  }
}

TEST(Stiffness, MultipliesLikeTheDenseMatrix) {
  const Problem problem(2);
  Vector x = some_vector(problem.size());
  Vector y(problem.size());
  for (const int threads : {1, 2, 5}) {
    const RowParts parts(problem.A(), threads);
    EXPECT_EQ(parts.count(), threads);
    PartedProduct(problem.A(), parts).multiply(span_of(x), span_of(y));
    EXPECT_TRUE(y.isApprox(dense(problem.A()) * x, 1e-13)) << threads;
  }
}

// The free unknowns under a displaced boundary: A u = load must be the full problem's equilibrium.
TEST(Stiffness, BoundaryLoadBalancesTheGivenDisplacement) {
  const Problem problem(2);
  const Stiffness all_free(problem.cells, Mask(problem.A().rows(), 0));
  Stiffness free = all_free;
  free.assemble(pseudo_solid(0.3, 1, 1), problem.mesh.points);
  Vector u = some_vector(problem.size());
  Vector by_node(problem.size());
  problem.stiffness.to_nodes(span_of(u), span_of(by_node));
  Vector load(problem.size());
  Vector load_by_node(problem.size());
  problem.stiffness.boundary_load(span_of(by_node), span_of(load_by_node));
  problem.stiffness.to_rows(span_of(load_by_node), span_of(load));
  Vector given = u;
  for (Eigen::Index i = 0; i < u.size(); ++i)
    if (!problem.is_given(i)) given[i] = 0;
  Vector expected = -(dense(free.matrix()) * given);
  for (Eigen::Index i = 0; i < u.size(); ++i)
    if (problem.is_given(i)) expected[i] = u[i];
  EXPECT_TRUE(load.isApprox(expected, 1e-13));
}

// Every node has a number of its own, and neighbours are closer than in a shuffled order.
TEST(Numbering, BringsNeighboursTogether) {
  const Problem problem(5);
  const auto n = problem.A().rows();
  auto shuffled = problem.cells;
  for (auto& node : shuffled.nodes) node = static_cast<std::int32_t>(static_cast<std::size_t>(node) * 7 % n);
  ASSERT_NE(n % 7, 0U); // or the shuffle would join nodes
  const auto bandwidth = [](const Cells& cells, const std::vector<std::int32_t>& number) {
    std::int32_t widest = 0;
    for (std::size_t e = 0; e < cells.count(); ++e)
      for (const std::int32_t node : cells.cell(e))
        widest = std::max(widest, std::abs(number[static_cast<std::size_t>(cells.cell(e)[0])] -
                                           number[static_cast<std::size_t>(node)]));
    return widest;
  };
  auto number = reverse_cuthill_mckee(shuffled, n);
  const auto after = bandwidth(shuffled, number);
  std::sort(number.begin(), number.end());
  for (std::size_t i = 0; i < n; ++i) ASSERT_EQ(number[i], static_cast<std::int32_t>(i));
  EXPECT_LT(3 * after, bandwidth(shuffled, number)); // `number` is now the given order
}

// On a pattern without fill the incomplete factors are the complete ones.
TEST(IncompleteCholesky, IsExactWithoutFill) {
  const Cells one_tet = {3, {0, 1, 2, 3}};
  auto A = lower_pattern(one_tet, 4);
  const Vector v = some_vector(144);
  const Eigen::Map<const Eigen::Matrix<double, 12, 12>> R(v.data());
  const Eigen::Matrix<double, 12, 12> full =
      R * R.transpose() + 4 * Eigen::Matrix<double, 12, 12>::Identity();
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = A.begin(i); k <= A.diagonal(i); ++k)
      A.block(k) = full.block<3, 3>(3 * static_cast<Eigen::Index>(i), 3 * A.column[k]);
  const RowParts parts(A, 1);
  IncompleteCholesky factors(A, parts);
  EXPECT_EQ(factors.factor(), 0);
  Vector x = some_vector(12);
  Vector z(12);
  factors.apply(span_of(x), span_of(z));
  EXPECT_LT((full * z - x).norm(), 1e-5 * x.norm()); // single precision
}

TEST(IncompleteCholesky, ShiftsWhereAPivotIsNotPositive) {
  const Cells one_tet = {3, {0, 1, 2, 3}};
  auto A = lower_pattern(one_tet, 4);
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = A.begin(i); k <= A.diagonal(i); ++k)
      A.block(k) =
          Eigen::Matrix3d::Identity() * (k == A.diagonal(i) ? 1.0 : -0.6); // indefinite: 1 - 3 * 0.6 < 0
  const RowParts parts(A, 1);
  IncompleteCholesky factors(A, parts);
  EXPECT_GT(factors.factor(), 0);
  Vector x = some_vector(12);
  Vector z(12);
  factors.apply(span_of(x), span_of(z));
  EXPECT_GT(x.dot(z), 0);
}

TEST(ConjugateGradient, SolvesToTheTolerance) {
  const Problem problem(6);
  const Vector exact = some_vector(problem.size());
  const Vector b = product(problem.A(), exact);
  for (const int threads : {1, 2, 3}) {
    ConjugateGradient solver(problem.A(), problem.stiffness.given_rows(), threads);
    ASSERT_TRUE(solver.update(problem.positions()).ok());
    Vector x = Vector::Zero(problem.size());
    const auto outcome =
        solver.solve({b.data(), static_cast<std::size_t>(b.size())}, span_of(x), 1e-12 * b.norm(), 1000);
    ASSERT_TRUE(outcome.ok());
    EXPECT_TRUE(outcome->converged);
    EXPECT_LT((x - exact).norm(), 1e-9 * exact.norm());
    EXPECT_LT(outcome->iterations, 100);
  }
}

// Direct factors and the iteration find the same.
TEST(LinearSolver, DirectAndIterativeAgree) {
  const Problem problem(4);
  const Vector b = some_vector(problem.size());
  Vector x[2];
  for (const bool direct : {false, true}) {
    LinearSolver solver(problem.A(), problem.stiffness.given_rows(), 3,
                        direct ? LinearSolverKind::direct : LinearSolverKind::iterative);
    EXPECT_EQ(solver.is_direct(), direct);
    ASSERT_TRUE(solver.update(problem.positions()).ok());
    x[direct] = Vector::Zero(problem.size());
    const auto outcome = solver.solve({b.data(), static_cast<std::size_t>(b.size())}, span_of(x[direct]),
                                      1e-12 * b.norm(), 1000);
    ASSERT_TRUE(outcome.ok());
    EXPECT_TRUE(outcome->converged);
  }
  EXPECT_LT((x[0] - x[1]).norm(), 1e-9 * x[1].norm());
}

// The coarse level carries a rigid translation through the whole mesh without an iteration.
TEST(CoarseSpace, SolvesATranslationAlone) {
  const Problem problem(6);
  ConjugateGradient solver(problem.A(), problem.stiffness.given_rows());
  ASSERT_TRUE(solver.update(problem.positions()).ok());
  Vector exact = Vector::Zero(problem.size());
  for (Eigen::Index i = 0; i < exact.size(); ++i)
    if (!problem.is_given(i)) exact[i] = 1 + static_cast<double>(i % 3);
  Vector b = product(problem.A(), exact);
  Vector x = Vector::Zero(problem.size());
  const auto outcome = solver.solve(span_of(b), span_of(x), 1e-11 * b.norm(), 1000);
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(outcome->iterations, 0);
  EXPECT_LT((x - exact).norm(), 1e-10 * exact.norm());
}

} // namespace
} // namespace drogue::mesh_mover
