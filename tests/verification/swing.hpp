// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Dense>

namespace drogue::test {

struct Swing {
  double omega = 0;
  double decay = 0; ///< part of the amplitude lost in a period; negative: gained
};

/// exp(-beta t) (a cos(omega t) + b sin(omega t)) + c of least squares, by golden sections in turn.
inline Swing fitted(const std::vector<double>& t, const std::vector<double>& w, double guess) {
  const auto misfit = [&](double omega, double beta) {
    Eigen::MatrixXd A(static_cast<Eigen::Index>(t.size()), 3);
    for (Eigen::Index i = 0; i < A.rows(); ++i) {
      const double time = t[static_cast<std::size_t>(i)], fade = std::exp(-beta * time);
      A.row(i) << fade * std::cos(omega * time), fade * std::sin(omega * time), 1;
    }
    const Eigen::Map<const Eigen::VectorXd> b(w.data(), A.rows());
    return (A * A.colPivHouseholderQr().solve(b) - b).norm();
  };
  const auto smallest = [](double lower, double upper, const auto& f) {
    constexpr double golden = 0.6180339887498949;
    for (int i = 0; i < 40; ++i) {
      const double a = upper - golden * (upper - lower), b = lower + golden * (upper - lower);
      if (f(a) < f(b))
        upper = b;
      else
        lower = a;
    }
    return 0.5 * (lower + upper);
  };
  double omega = guess, beta = 0;
  for (int i = 0; i < 6; ++i) {
    omega = smallest(0.5 * guess, 2 * guess, [&](double value) { return misfit(value, beta); });
    beta = smallest(-guess, guess, [&](double value) { return misfit(omega, value); });
  }
  return {omega, 1 - std::exp(-beta * 2 * std::numbers::pi / omega)};
}

} // namespace drogue::test
