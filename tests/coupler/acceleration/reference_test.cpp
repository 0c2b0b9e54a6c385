// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include <Eigen/Dense>

#include "coupler/acceleration/accelerator.hpp"

/// The accelerators against dense textbook formulas, iterate by iterate, on nonlinear problems with known
/// roots.
namespace drogue::acceleration {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

constexpr Eigen::Index n = 8;
constexpr double relaxation = 0.1;

/// Its root in the step `s` is root(s): a heavy fluid, a little nonlinear, turned a little from step to step.
Vector root(int s) {
  Vector x(n);
  for (Eigen::Index i = 0; i < n; ++i)
    x[i] = 1 + 0.1 * static_cast<double>(i) + 0.3 * std::sin(0.5 * s + static_cast<double>(i));
  return x;
}
Vector H(int s, const Vector& x) {
  const auto g = [s](const Vector& y) {
    Vector v(n);
    for (Eigen::Index i = 0; i < n; ++i)
      v[i] = -(0.5 + static_cast<double>(i)) * (y[i] + 0.05 * y[i] * y[i]) +
             0.3 * std::sin(y[(i + 1) % n] + 0.1 * s);
    return v;
  };
  return root(s) + g(x) - g(root(s));
}

/// Secants of a step, newest first.
struct Secants {
  std::deque<Vector> dr, dh;
  [[nodiscard]] Matrix V() const { return matrix(dr); }
  [[nodiscard]] Matrix W() const { return matrix(dh); }

 private:
  static Matrix matrix(const std::deque<Vector>& columns) {
    Matrix m(n, static_cast<Eigen::Index>(columns.size()));
    for (std::size_t j = 0; j < columns.size(); ++j) m.col(static_cast<Eigen::Index>(j)) = columns[j];
    return m;
  }
};

Matrix pseudo_inverse(const Matrix& V) {
  return V.completeOrthogonalDecomposition().pseudoInverse();
}

/// All secants of the steps kept, in one least squares.
Vector ils(const std::deque<Secants>& steps, const Vector& h, const Vector& r) {
  Secants all;
  for (const Secants& s : steps) {
    all.dr.insert(all.dr.end(), s.dr.begin(), s.dr.end());
    all.dh.insert(all.dh.end(), s.dh.begin(), s.dh.end());
  }
  return h - all.W() * pseudo_inverse(all.V()) * r;
}

/// J = J_before + (W - J_before V) V^+, from the oldest step to the newest.
Vector imvj(const std::deque<Secants>& steps, const Vector& h, const Vector& r) {
  Matrix J = Matrix::Zero(n, n);
  for (auto s = steps.rbegin(); s != steps.rend(); ++s)
    if (!s->dr.empty()) J += (s->W() - J * s->V()) * pseudo_inverse(s->V());
  return h - J * r;
}

/// Runs steps with ours; every next iterate is compared with the formula. Iterations of the last step.
template <class Formula>
int compare(Method method, int reuse, Formula formula) {
  auto ours =
      make_accelerator({.method = method, .relaxation = relaxation, .reuse_steps = reuse, .filter = 1e-6},
                       static_cast<std::size_t>(n));
  EXPECT_TRUE(ours.ok());
  std::deque<Secants> steps; // newest first
  Vector x = Vector::Zero(n), next(n);
  int iterations = 0;
  for (int s = 0; s < 5; ++s) {
    (*ours)->begin_step();
    steps.emplace_front();
    if (static_cast<int>(steps.size()) > reuse + 1) steps.pop_back();
    Vector h_last, r_last;
    for (iterations = 1; iterations < 60; ++iterations) {
      const Vector h = H(s, x), r = h - x;
      if (r.norm() < 1e-8) break;
      if (h_last.size() > 0) {
        steps.front().dr.push_front(r - r_last);
        steps.front().dh.push_front(h - h_last);
      }
      h_last = h;
      r_last = r;
      bool any = false;
      for (const Secants& kept : steps) any = any || !kept.dr.empty();
      const Vector expected = any ? formula(steps, h, r) : Vector(x + relaxation * r);
      const auto size = static_cast<std::size_t>(n);
      EXPECT_TRUE((*ours)->next({std::span(x.data(), size), std::span(h.data(), size)},
                                std::span(next.data(), size)));
      // With as many secants as unknowns the least squares have no unique solution any more.
      std::size_t secants = 0;
      for (const Secants& kept : steps) secants = std::max(secants, kept.dr.size());
      if (secants < static_cast<std::size_t>(n)) {
        EXPECT_LT((next - expected).norm(), 1e-6 + 1e-3 * r.norm())
            << "step " << s << " iteration " << iterations;
      }
      x = next;
    }
    EXPECT_LT((x - root(s)).norm(), 1e-6) << "step " << s;
    (*ours)->end_step(true);
  }
  return iterations;
}

TEST(Reference, IqnIls) {
  EXPECT_LE(compare(Method::iqn_ils, 0, ils), 14);
}

TEST(Reference, IqnImvj) {
  const int with = compare(Method::iqn_imvj, 4, imvj);
  EXPECT_LE(with, 8);
  EXPECT_LT(with, compare(Method::iqn_imvj, 0, imvj)); // the steps before help
}

TEST(Reference, OfOneStepIqnImvjIsIqnIls) {
  EXPECT_EQ(compare(Method::iqn_imvj, 0, ils), compare(Method::iqn_ils, 0, imvj));
}

/// omega_k = -omega_{k-1} <r_{k-1}, r_k - r_{k-1}> / |r_k - r_{k-1}|^2
TEST(Reference, Aitken) {
  auto ours = make_accelerator({.method = Method::aitken, .relaxation = relaxation, .max_relaxation = 2},
                               static_cast<std::size_t>(n));
  ASSERT_TRUE(ours.ok());
  (*ours)->begin_step();
  Vector x = Vector::Zero(n), next(n), r_last;
  double omega = relaxation;
  int k = 0;
  for (; k < 400 && (H(0, x) - x).norm() > 1e-9; ++k) {
    const Vector h = H(0, x), r = h - x;
    if (k > 0) omega *= -r_last.dot(r - r_last) / (r - r_last).squaredNorm();
    omega = std::clamp(omega, -2.0, 2.0);
    const auto size = static_cast<std::size_t>(n);
    ASSERT_TRUE(
        (*ours)->next({std::span(x.data(), size), std::span(h.data(), size)}, std::span(next.data(), size)));
    EXPECT_LT((next - (x + omega * r)).norm(), 1e-9 * (1 + next.norm())) << k;
    x = next;
    r_last = r;
  }
  EXPECT_LT(k, 400);
  EXPECT_LT((x - root(0)).norm(), 1e-8);
}

TEST(Forget, StartsAnew) {
  for (const Method method : {Method::aitken, Method::iqn_ils, Method::iqn_imvj}) {
    auto a = make_accelerator({.method = method, .relaxation = relaxation}, static_cast<std::size_t>(n));
    ASSERT_TRUE(a.ok());
    (*a)->begin_step();
    Vector x = Vector::Zero(n), next(n);
    const auto size = static_cast<std::size_t>(n);
    const auto advance = [&] {
      const Vector h = H(0, x);
      EXPECT_TRUE(
          (*a)->next({std::span(x.data(), size), std::span(h.data(), size)}, std::span(next.data(), size)));
      return Vector(next - x - relaxation * (h - x));
    };
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(advance().norm() < 1e-14, k == 0);
      x = next;
    }
    (*a)->forget();
    EXPECT_LT(advance().norm(), 1e-14); // the first relaxation again
  }
}

} // namespace
} // namespace drogue::acceleration
