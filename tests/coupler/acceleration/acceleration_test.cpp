// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "coupler/acceleration/accelerator.hpp"

namespace drogue::acceleration {
namespace {

using Vector = std::vector<double>;
using Map = std::function<Vector(const Vector&)>;

std::unique_ptr<Accelerator> make(const Settings& settings, std::size_t n, std::size_t passenger = 0,
                                  const Vector& weights = {}) {
  auto made = make_accelerator(settings, n, passenger, weights);
  EXPECT_TRUE(made.ok());
  return std::move(made).value();
}

double residual(const Map& H, const Vector& x) {
  const Vector h = H(x);
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += (h[i] - x[i]) * (h[i] - x[i]);
  return std::sqrt(sum);
}

/// Evaluations of H until the residual is below the tolerance; 1000 when that does not happen.
int iterate(Accelerator& accelerator, const Map& H, Vector& x, double tolerance) {
  accelerator.begin_step();
  for (int k = 1; k < 1000; ++k) {
    const Vector h = H(x);
    if (residual(H, x) < tolerance) {
      accelerator.end_step(true);
      return k;
    }
    EXPECT_TRUE(accelerator.next({x, h}, x));
  }
  accelerator.end_step(false);
  return 1000;
}

/// H(x) = A x + b, of full rank, with eigenvalues beyond -1: a plain iteration diverges, as with a heavy
/// fluid.
Vector linear_map(const Vector& x) {
  const std::size_t n = x.size();
  Vector h(n);
  for (std::size_t i = 0; i < n; ++i) {
    h[i] = 1.0 + static_cast<double>(i) - (1.5 + 0.7 * static_cast<double>(i)) * x[i];
    if (i > 0) h[i] += 0.4 * x[i - 1];
    if (i + 1 < n) h[i] -= 0.3 * x[i + 1];
  }
  return h;
}

/// Componentwise -2 x + 0.3 sin(x) plus a coupling, shifted so that its root is 1, 2, ..., n.
Vector nonlinear_map(const Vector& x) {
  const std::size_t n = x.size();
  const auto g = [n](const Vector& v, std::size_t i) {
    return -2 * v[i] + 0.3 * std::sin(v[i]) + 0.2 * v[(i + 1) % n] * v[i] / 10;
  };
  Vector root(n), h(n);
  for (std::size_t i = 0; i < n; ++i) root[i] = static_cast<double>(i + 1);
  for (std::size_t i = 0; i < n; ++i) h[i] = root[i] + g(x, i) - g(root, i);
  return h;
}

TEST(ConstantRelaxation, IsTheFormula) {
  auto a = make({.method = Method::constant, .relaxation = 0.25}, 2, 1);
  Vector x{1, 2}, v{8};
  const Vector h{5, -2}, vh{0};
  a->begin_step();
  ASSERT_TRUE(a->next({x, h, v, vh}, x, v));
  EXPECT_DOUBLE_EQ(x[0], 2);
  EXPECT_DOUBLE_EQ(x[1], 1);
  EXPECT_DOUBLE_EQ(v[0], 6);
}

TEST(Aitken, SecondStepIsTheFormula) {
  auto a = make({.method = Method::aitken, .relaxation = 0.1, .max_relaxation = 5}, 2);
  const Vector x0{0, 0}, h0{1, 2};
  Vector x1(2), x2(2);
  a->begin_step();
  ASSERT_TRUE(a->next({x0, h0}, x1));
  EXPECT_DOUBLE_EQ(x1[0], 0.1);
  const Vector h1{0.9, 1.2}; // r0 = (1, 2), r1 = (0.8, 1.0), dr = (-0.2, -1)
  ASSERT_TRUE(a->next({x1, h1}, x2));
  const double omega = -0.1 * (1 * -0.2 + 2 * -1.0) / (0.04 + 1.0);
  EXPECT_NEAR(x2[0], 0.1 + omega * 0.8, 1e-15);
  EXPECT_NEAR(x2[1], 0.2 + omega * 1.0, 1e-15);
}

TEST(Aitken, IsExactInOneUnknownAndGuardsItsDivision) {
  const Map H = [](const Vector& x) { return Vector{3 - 4 * x[0]}; };
  auto a = make({.method = Method::aitken, .relaxation = 0.05}, 1);
  Vector x{10};
  EXPECT_EQ(iterate(*a, H, x, 1e-12), 3);
  EXPECT_NEAR(x[0], 0.6, 1e-12);
  // The same residual twice: the difference is zero, and the factor stays what it was.
  auto b = make({.method = Method::aitken, .relaxation = 0.05}, 1);
  b->begin_step();
  Vector y{0};
  for (int k = 1; k <= 3; ++k) {
    const Vector h{y[0] + 1};
    ASSERT_TRUE(b->next({y, h}, y));
    EXPECT_NEAR(y[0], 0.05 * k, 1e-14);
  }
}

TEST(Aitken, ForgetsTheFactorOfAStepThatFailed) {
  auto a = make({.method = Method::aitken, .relaxation = 0.05}, 1);
  const Map H = [](const Vector& x) { return Vector{3 - 4 * x[0]}; };
  Vector x{10};
  iterate(*a, H, x, 1e-12);
  EXPECT_NEAR(a->save().omega, 0.2, 1e-12);
  a->begin_step();
  a->end_step(false);
  EXPECT_EQ(a->save().omega, 0.05);
}

TEST(IqnIls, SolvesALinearProblemInOneMoreThanItsSize) {
  for (const std::size_t n : {1, 2, 3, 5}) {
    auto a = make({.relaxation = 0.1, .filter = 1e-7}, n);
    Vector x(n, 0.5);
    // n + 1 updates, so n + 2 evaluations with the one that finds it converged.
    EXPECT_LE(iterate(*a, linear_map, x, 1e-9), static_cast<int>(n) + 2) << n;
    EXPECT_LT(residual(linear_map, x), 1e-9);
  }
}

TEST(IqnIls, IsNeverFasterThanItsSizeAllows) { // shows that the test above can fail
  auto a = make({.relaxation = 0.1, .filter = 1e-7}, 5);
  Vector x(5, 0.5);
  EXPECT_GE(iterate(*a, linear_map, x, 1e-9), 6);
  auto plain = make({.method = Method::constant, .relaxation = 1}, 5);
  Vector y(5, 0.5);
  plain->begin_step();
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(plain->next({y, linear_map(y)}, y));
  EXPECT_GT(residual(linear_map, y), 1e3);
}

TEST(IqnIls, FindsTheRootOfANonlinearProblem) {
  const std::size_t n = 6;
  auto a = make({.relaxation = 0.1}, n);
  Vector x(n, 0.0);
  EXPECT_LT(iterate(*a, nonlinear_map, x, 1e-11), 20);
  for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(x[i], static_cast<double>(i + 1), 1e-10);
  auto b = make({.method = Method::aitken, .relaxation = 0.1}, n);
  Vector y(n, 0.0);
  EXPECT_LT(iterate(*b, nonlinear_map, y, 1e-10), 200);
  EXPECT_NEAR(y[3], 4, 1e-9);
}

TEST(IqnIls, ReusesColumnsFromTheFirstIterationOfTheNextStep) {
  const std::size_t n = 5;
  const Map shifted = [](const Vector& x) {
    Vector h = linear_map(x);
    for (double& v : h) v += 0.7;
    return h;
  };
  auto with = make({.relaxation = 0.1, .reuse_steps = 2, .filter = 1e-7}, n);
  auto without = make({.relaxation = 0.1, .reuse_steps = 0, .filter = 1e-7}, n);
  Vector x(n, 0.5), y(n, 0.5);
  iterate(*with, linear_map, x, 1e-9);
  iterate(*without, linear_map, y, 1e-9);
  const int fast = iterate(*with, shifted, x, 1e-8);
  const int slow = iterate(*without, shifted, y, 1e-8);
  EXPECT_LE(fast, 3);
  EXPECT_GE(slow, static_cast<int>(n));
  for (int k = 0; k < 3; ++k) { // the columns age
    with->begin_step();
    with->end_step(true);
  }
  EXPECT_TRUE(with->save().column_step.empty());
}

TEST(IqnIls, FilterDropsDependentColumns) {
  auto a = make({.relaxation = 0.1, .filter = 1e-2}, 3);
  a->begin_step();
  const Vector r[] = {{1, 0, 0}, {0.5, 0, 0}, {0.25, 1e-4, 0}, {0.125, 1e-4, 1}};
  Vector x(3, 0.0), next(3);
  for (const Vector& ri : r) ASSERT_TRUE(a->next({x, ri}, next));
  // Differences: (-.5, 0, 0), (-.25, 1e-4, 0), (-.125, 0, 1): the oldest is nearly the second.
  EXPECT_EQ(a->used_columns(), 2);
  EXPECT_EQ(a->dropped_columns(), 1);
  auto b = make({.relaxation = 0.1, .filter = 1e-5}, 3);
  b->begin_step();
  for (const Vector& ri : r) ASSERT_TRUE(b->next({x, ri}, next));
  EXPECT_EQ(b->used_columns(), 3);
  EXPECT_EQ(b->dropped_columns(), 0);
}

TEST(IqnIls, DropsAColumnOfZerosAndTheOldestBeyondTheLimit) {
  auto a = make({.relaxation = 0.1, .max_columns = 2}, 4);
  a->begin_step();
  Vector x(4, 0.0), next(4);
  const Vector same{1, 2, 3, 4};
  ASSERT_TRUE(a->next({x, same}, next));
  ASSERT_TRUE(a->next({x, same}, next));
  EXPECT_EQ(a->used_columns(), 0);
  EXPECT_NEAR(next[3], 0.4, 1e-15);
  for (int k = 0; k < 4; ++k) {
    Vector r(4, 1.0);
    r[static_cast<std::size_t>(k)] = 5;
    ASSERT_TRUE(a->next({x, r}, next));
  }
  EXPECT_EQ(a->save().column_step.size(), 2U);
}

/// The least squares with weights are those of the rows scaled by their roots.
TEST(IqnIls, WeightsChangeTheLeastSquares) {
  const Vector weights{4, 1};
  auto a = make({.relaxation = 0.1}, 2, 0, weights);
  auto plain = make({.relaxation = 0.1}, 2);
  const Vector x0{0, 0}, h0{1, 1}, x1{0.1, 0.1}, h1{0.5, 1.3};
  Vector y(2), z(2);
  a->begin_step();
  plain->begin_step();
  ASSERT_TRUE(a->next({x0, h0}, y) && a->next({x1, h1}, y));
  ASSERT_TRUE(plain->next({x0, h0}, z) && plain->next({x1, h1}, z));
  const double r[] = {0.4, 1.2}, dr[] = {-0.6, 0.2};
  const double c = -(4 * r[0] * dr[0] + r[1] * dr[1]) / (4 * dr[0] * dr[0] + dr[1] * dr[1]);
  EXPECT_NEAR(y[0], h1[0] + c * (h1[0] - h0[0]), 1e-14);
  EXPECT_NEAR(y[1], h1[1] + c * (h1[1] - h0[1]), 1e-14);
  EXPECT_GT(std::abs(y[0] - z[0]), 1e-3);
}

/// v = 3 x + 7 before, so v = 3 x + 7 after, whatever the combination.
TEST(Passenger, StaysAnAffineFunctionOfX) {
  const std::size_t n = 4;
  const auto passenger = [](const Vector& x) {
    Vector v(x);
    for (double& value : v) value = 3 * value + 7;
    return v;
  };
  for (const Method method : {Method::constant, Method::aitken, Method::iqn_ils, Method::iqn_imvj}) {
    auto a = make({.method = method, .relaxation = 0.2}, n, n);
    Vector x(n, 0.1), v = passenger(x);
    for (int step = 0; step < 2; ++step) {
      a->begin_step();
      for (int k = 0; k < 4; ++k) {
        const Vector h = nonlinear_map(x), vh = passenger(h);
        ASSERT_TRUE(a->next({x, h, v, vh}, x, v));
        const Vector exact = passenger(x);
        for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(v[i], exact[i], 1e-11 * (1 + std::abs(exact[i])));
      }
      a->end_step(true);
    }
  }
}

Vector run_step(Accelerator& a, Vector x, int iterations) {
  a.begin_step();
  Vector v(x);
  for (int k = 0; k < iterations; ++k) {
    const Vector h = nonlinear_map(x), vh(h);
    EXPECT_TRUE(a.next({x, h, v, vh}, x, v));
  }
  a.end_step(true);
  return x;
}

TEST(State, SaveAndRestoreContinueToTheBit) {
  for (const Method method : {Method::constant, Method::aitken, Method::iqn_ils, Method::iqn_imvj}) {
    const Settings settings{.method = method, .relaxation = 0.1};
    auto a = make(settings, 5, 5, {1, 2, 3, 4, 5}), b = make(settings, 5, 5, {1, 2, 3, 4, 5});
    const Vector x = run_step(*a, run_step(*a, Vector(5, 0.0), 4), 3);
    ASSERT_TRUE(b->restore(a->save()).ok());
    EXPECT_EQ(run_step(*a, x, 4), run_step(*b, x, 4));
    if (method == Method::constant) continue;
    auto fresh = make(settings, 5, 5, {1, 2, 3, 4, 5}); // the history matters
    auto c = make(settings, 5, 5, {1, 2, 3, 4, 5});
    ASSERT_TRUE(c->restore(b->save()).ok());
    EXPECT_NE(run_step(*fresh, x, 4), run_step(*c, x, 4));
  }
}

TEST(State, RollbackGivesBackTheStateAtBeginStep) {
  for (const Method method : {Method::aitken, Method::iqn_ils, Method::iqn_imvj}) {
    const Settings settings{.method = method, .relaxation = 0.1, .reuse_steps = 1, .max_columns = 4};
    auto a = make(settings, 5, 5), b = make(settings, 5, 5);
    const Vector x = run_step(*a, Vector(5, 0.0), 4), y = run_step(*b, Vector(5, 0.0), 4);
    run_step(*a, Vector(5, 0.3), 5); // pushes out columns of the step before
    a->rollback();
    EXPECT_EQ(run_step(*a, x, 4), run_step(*b, y, 4));
  }
}

TEST(Errors, AreRefused) {
  EXPECT_FALSE(make_accelerator({}, 0).ok());
  EXPECT_FALSE(make_accelerator({.relaxation = 0}, 2).ok());
  EXPECT_FALSE(make_accelerator({.filter = 1}, 2).ok());
  EXPECT_FALSE(make_accelerator({.reuse_steps = -1}, 2).ok());
  const Vector negative{1, -1};
  const auto bad = make_accelerator({}, 2, 0, negative);
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().kind, ErrorKind::config);
  auto a = make({}, 2);
  const Vector x{0, 0}, nan{1, std::numeric_limits<double>::quiet_NaN()};
  Vector y{3, 4};
  a->begin_step();
  EXPECT_FALSE(a->next({x, nan}, y));
  EXPECT_EQ(y, (Vector{3, 4}));
  State wrong;
  wrong.column_step = {1};
  EXPECT_FALSE(a->restore(wrong).ok());
}

} // namespace
} // namespace drogue::acceleration
