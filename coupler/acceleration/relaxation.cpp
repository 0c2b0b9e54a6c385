// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/acceleration/relaxation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "coupler/acceleration/vector_ops.hpp"

namespace drogue::acceleration {

void relax(double omega, std::span<const double> a, std::span<const double> b, std::span<double> y) noexcept {
  for (std::size_t i = 0; i < a.size(); ++i) y[i] = a[i] + omega * (b[i] - a[i]);
}

bool ConstantRelaxation::next(const Iterate& at, std::span<double> x_next, std::span<double> passenger_next) {
  if (!all_finite(at.h) || !all_finite(at.h_passenger)) return false;
  relax(omega_, at.x, at.h, x_next);
  relax(omega_, at.x_passenger, at.h_passenger, passenger_next);
  return true;
}

AitkenRelaxation::AitkenRelaxation(const Settings& settings, std::span<const double> weights, std::size_t n)
    : relaxation_(settings.relaxation),
      max_(settings.max_relaxation),
      weights_(n, 1.0),
      r_(n),
      r_last_(n),
      omega_(settings.relaxation),
      omega_at_begin_(settings.relaxation) {
  if (!weights.empty()) weights_.assign(weights.begin(), weights.end());
}

void AitkenRelaxation::begin_step() {
  omega_at_begin_ = omega_;
  const double smallest = std::min(0.5 * relaxation_, max_);
  omega_ = std::clamp(std::abs(omega_), smallest, max_);
  has_last_ = false;
}

bool AitkenRelaxation::next(const Iterate& at, std::span<double> x_next, std::span<double> passenger_next) {
  if (!all_finite(at.h) || !all_finite(at.h_passenger)) return false;
  double numerator = 0, denominator = 0, size = 0;
  for (std::size_t i = 0; i < r_.size(); ++i) {
    r_[i] = at.h[i] - at.x[i];
    const double dr = r_[i] - r_last_[i];
    numerator += weights_[i] * r_last_[i] * dr;
    denominator += weights_[i] * dr * dr;
    size += weights_[i] * r_[i] * r_[i];
  }
  constexpr double eps = std::numeric_limits<double>::epsilon();
  if (has_last_ && denominator > eps * eps * size) {
    const double omega = -omega_ * numerator / denominator;
    // A zero factor would keep x for ever: a tiny one of the same sign keeps the iteration alive.
    if (std::isfinite(omega))
      omega_ = std::copysign(std::clamp(std::abs(omega), 1e-6 * relaxation_, max_), omega);
  }
  r_last_.swap(r_);
  has_last_ = true;
  relax(omega_, at.x, at.h, x_next);
  relax(omega_, at.x_passenger, at.h_passenger, passenger_next);
  return true;
}

void AitkenRelaxation::forget() {
  omega_ = relaxation_;
  has_last_ = false;
}

void AitkenRelaxation::end_step(bool converged) {
  if (!converged) omega_ = relaxation_;
}

State AitkenRelaxation::save() const {
  State state;
  state.omega = omega_;
  return state;
}

Result<void> AitkenRelaxation::restore(const State& state) {
  if (!std::isfinite(state.omega) || std::abs(state.omega) > max_)
    return config_error("accelerator state: omega = {} is outside [-{}, {}]", state.omega, max_, max_);
  omega_ = state.omega;
  has_last_ = false;
  return {};
}

} // namespace drogue::acceleration
