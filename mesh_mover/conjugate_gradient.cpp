// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/conjugate_gradient.hpp"

#include <cmath>
#include <numeric>
#include <utility>

namespace drogue::mesh_mover {
namespace {

std::span<const double> values(const Eigen::VectorXd& v) {
  return {v.data(), static_cast<std::size_t>(v.size())};
}
std::span<double> values(Eigen::VectorXd& v) {
  return {v.data(), static_cast<std::size_t>(v.size())};
}

} // namespace

ConjugateGradient::ConjugateGradient(const SymmetricBlocks<double>& A, const Mask& given, SharedRows rows,
                                     int threads)
    : rows_(std::move(rows)),
      parts_(A, rows_.own(), threads),
      A_(A, parts_),
      incomplete_(A, parts_),
      coarse_(A, given, rows_) {
  const auto n = static_cast<Eigen::Index>(3 * A.rows());
  for (Vector* v : {&r_, &z_, &p_, &w_}) v->setZero(n);
  sums_.resize(static_cast<std::size_t>(parts_.count()));
}

template <class Function>
void ConjugateGradient::for_each_part(Function&& function) {
  parts_.run([&](int part) {
    const auto begin = static_cast<Eigen::Index>(3 * parts_.begin(part));
    const auto end = static_cast<Eigen::Index>(3 * parts_.end(part));
    function(static_cast<std::size_t>(part), Eigen::seqN(begin, end - begin));
  });
}

double ConjugateGradient::dot(const Vector& a, const Vector& b) {
  for_each_part([&](std::size_t part, auto range) { sums_[part] = a(range).dot(b(range)); });
  return rows_.sum(std::accumulate(sums_.begin(), sums_.end(), 0.0));
}

Result<void> ConjugateGradient::update(std::span<const double> positions) {
  incomplete_.factor();
  return coarse_.factor(positions);
}

Result<void> ConjugateGradient::precondition(const Vector& r, Vector& z) {
  incomplete_.apply(values(r), values(z));
  return coarse_.add(values(r), values(z));
}

Result<SolveOutcome> ConjugateGradient::solve(std::span<const double> b, std::span<double> x,
                                              double tolerance, int max_iterations) {
  const auto n = static_cast<Eigen::Index>(b.size());
  const Eigen::Map<const Vector> rhs(b.data(), n);
  Eigen::Map<Vector> solution(x.data(), n);
  // 1. coarse correction of the start value
  const auto find_residual = [&] {
    A_.multiply(x, values(w_));
    for_each_part([&](std::size_t, auto range) { r_(range) = rhs(range) - w_(range); });
  };
  find_residual();
  DROGUE_TRY(coarse_.add(values(r_), x));
  rows_.fetch(x);
  find_residual();
  // 2. preconditioned conjugate gradients
  SolveOutcome outcome{false, 0, std::sqrt(dot(r_, r_))};
  double rz = 0;
  while (!(outcome.converged = outcome.residual <= tolerance) && outcome.iterations < max_iterations) {
    DROGUE_TRY(precondition(r_, z_));
    const double rz_new = dot(r_, z_);
    const double beta = outcome.iterations == 0 ? 0 : rz_new / rz;
    rz = rz_new;
    for_each_part([&](std::size_t, auto range) {
      if (beta == 0)
        p_(range) = z_(range); // what p_ held before may not be finite
      else
        p_(range) = z_(range) + beta * p_(range);
    });
    rows_.fetch(values(p_));
    A_.multiply(values(p_), values(w_));
    const double curvature = dot(p_, w_);
    if (!(curvature > 0)) break; // rounding, or values that are not finite
    const double alpha = rz / curvature;
    for_each_part([&](std::size_t part, auto range) {
      solution(range) += alpha * p_(range);
      r_(range) -= alpha * w_(range);
      sums_[part] = r_(range).squaredNorm();
    });
    outcome.residual = std::sqrt(rows_.sum(std::accumulate(sums_.begin(), sums_.end(), 0.0)));
    ++outcome.iterations;
  }
  rows_.gather(x);
  return outcome;
}

} // namespace drogue::mesh_mover
