// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/conjugate_gradient.hpp"

namespace drogue::mesh_mover {
namespace {

std::span<const double> values(const Eigen::VectorXd& v) {
  return {v.data(), static_cast<std::size_t>(v.size())};
}
std::span<double> values(Eigen::VectorXd& v) {
  return {v.data(), static_cast<std::size_t>(v.size())};
}

} // namespace

ConjugateGradient::ConjugateGradient(const SymmetricBlocks<double>& A, const Mask& given)
    : A_(A), coarse_(A, given) {
  const auto n = static_cast<Eigen::Index>(3 * A.rows());
  for (Vector* v : {&r_, &z_, &p_, &w_}) v->resize(n);
}

Result<void> ConjugateGradient::update() {
  incomplete_.factor(A_);
  return coarse_.factor(A_);
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
  multiply(A_, x, values(w_));
  r_ = rhs - w_;
  DROGUE_TRY(coarse_.add(values(r_), x));
  multiply(A_, x, values(w_));
  r_ = rhs - w_;
  // 2. preconditioned conjugate gradients
  SolveOutcome outcome{false, 0, r_.norm()};
  double rz = 0;
  while (!(outcome.converged = outcome.residual <= tolerance) && outcome.iterations < max_iterations) {
    DROGUE_TRY(precondition(r_, z_));
    const double rz_new = r_.dot(z_);
    if (outcome.iterations == 0)
      p_ = z_;
    else
      p_ = z_ + (rz_new / rz) * p_;
    rz = rz_new;
    multiply(A_, values(p_), values(w_));
    const double curvature = p_.dot(w_);
    if (!(curvature > 0)) break; // rounding, or values that are not finite
    const double alpha = rz / curvature;
    solution += alpha * p_;
    r_ -= alpha * w_;
    outcome.residual = r_.norm();
    ++outcome.iterations;
  }
  return outcome;
}

} // namespace drogue::mesh_mover
