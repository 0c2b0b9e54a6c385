// SPDX-License-Identifier: GPL-3.0-or-later
// What a StepLoop starts a step from, and how it measures an iteration.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "coupler/scheme/step_loop.hpp"

namespace drogue::coupler {

bool StepLoop::is_small(double first_residual) const {
  const LoopSettings& loop = settings_.loop;
  const auto holds = [](double asked, double value) { return !(asked > 0) || value <= asked; };
  return (record_.residual_relative <= loop.relative || record_.residual_absolute <= loop.absolute) &&
         holds(loop.residual_relative * first_residual, record_.residual_absolute) &&
         holds(loop.velocity_relative, record_.velocity_residual) &&
         holds(loop.load_relative, record_.load_change);
}

/// L2 norm of the load whose nodal forces are given, over the square root of the area [stress].
double StepLoop::density_norm(std::span<const double> force) {
  for (std::size_t i = 0; i < force.size(); ++i) work_[i] = force[i] / weights_[i];
  return exchange_.norm(work_);
}

/// Extrapolates d, v and in STRUCTURE_FIRST the load f from the last levels (Lagrange polynomials over steps
/// of any length).
void StepLoop::predict(double time_step) {
  const int order = std::min(settings_.loop.predictor, known_levels_ - 1);
  const double a = n_.time_step, b = n_minus_1_.time_step, h = time_step;
  double w0 = 1, w1 = 0, w2 = 0;
  if (order == 1) {
    w0 = 1 + h / a;
    w1 = -h / a;
  } else if (order == 2) {
    w0 = (h + a) * (h + a + b) / (a * (a + b));
    w1 = -h * (h + a + b) / (a * b);
    w2 = h * (h + a) / ((a + b) * b);
  }
  const auto extrapolate = [&](std::vector<double> Level::*of, std::vector<double>& to) {
    for (std::size_t i = 0; i < to.size(); ++i)
      to[i] = w0 * (n_.*of)[i] + (w1 != 0 ? w1 * (n_minus_1_.*of)[i] : 0) +
              (w2 != 0 ? w2 * (n_minus_2_.*of)[i] : 0);
  };
  extrapolate(&Level::d, d_);
  extrapolate(&Level::v, v_);
  f_ = n_.f;
  if (settings_.loop.scheme == Scheme::structure_first) extrapolate(&Level::f, f_);
}

/// What the iteration iterates on, and what came of it: d and d~, in STRUCTURE_FIRST f and f~.
double StepLoop::distance(std::span<const double> a, std::span<const double> b) {
  for (std::size_t i = 0; i < a.size(); ++i) work_[i] = a[i] - b[i];
  return settings_.loop.scheme == Scheme::structure_first ? density_norm(work_) : exchange_.norm(work_);
}

void StepLoop::measure(double time_step) {
  const std::size_t n = d_.size();
  const bool by_load = settings_.loop.scheme == Scheme::structure_first;
  record_.increment = by_load ? distance(exchange_.force(), n_.f) : distance(d_tilde_, n_.d);
  record_.residual_absolute = by_load ? distance(exchange_.force(), f_) : distance(d_tilde_, d_);
  const double scale = std::max(record_.increment, settings_.loop.floor);
  record_.residual_relative = record_.residual_absolute / scale;
  double moved = scale;
  if (by_load) {
    for (std::size_t i = 0; i < n; ++i) work_[i] = d_tilde_[i] - n_.d[i];
    moved = std::max(exchange_.norm(work_), 1e-300);
  }
  for (std::size_t i = 0; i < n; ++i) work_[i] = (v_tilde_[i] - v_[i]) * time_step;
  record_.velocity_residual = exchange_.norm(work_) / moved;
  const std::span<const double> f_tilde = exchange_.force();
  for (std::size_t i = 0; i < n; ++i) work_[i] = f_tilde[i] - f_[i];
  const double of_load = std::sqrt(std::inner_product(f_tilde.begin(), f_tilde.end(), f_tilde.begin(), 0.0));
  record_.load_change = std::sqrt(std::inner_product(work_.begin(), work_.end(), work_.begin(), 0.0)) /
                        std::max(of_load, 1e-300);
  for (std::size_t i = 0; i < n; ++i) work_[i] = 0.5 * (v_start_[i] + v_[i]) * time_step - (d_[i] - n_.d[i]);
  record_.sweep_defect = exchange_.norm(work_) / moved;
}

/// From two evaluations of the first step: H carries -M_added/M_structure of a change of d (or f) back.
void StepLoop::learn_added_mass(int iteration) {
  if (settings_.loop.scheme == Scheme::parallel) return; // there d~ answers to another load than that of d
  const bool by_load = settings_.loop.scheme == Scheme::structure_first;
  const std::span<const double> x = by_load ? f_ : d_, h = by_load ? exchange_.force() : d_tilde_;
  if (totals_.added_mass_ratio == 0 && iteration == 2) {
    const double dx = distance(x, x_before_);
    if (dx > 0) totals_.added_mass_ratio = distance(h, h_before_) / dx;
  }
  x_before_.assign(x.begin(), x.end());
  h_before_.assign(h.begin(), h.end());
}

} // namespace drogue::coupler
