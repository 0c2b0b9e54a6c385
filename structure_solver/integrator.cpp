// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/integrator.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "structure_solver/drag_assembly.hpp"
#include "structure_solver/norm.hpp"

namespace drogue::structure {
namespace {

double largest_nodal(std::span<const double> x) noexcept {
  double largest = 0;
  for (std::size_t i = 0; i + 2 < x.size(); i += 3)
    largest = std::max(largest, x[i] * x[i] + x[i + 1] * x[i + 1] + x[i + 2] * x[i + 2]);
  return std::sqrt(largest);
}

} // namespace

State rest_state(const Model& model) {
  const std::vector<double> zero(model.equation_count(), 0.0);
  State state;
  state.u = state.v = state.a = zero;
  return state;
}

GeneralisedAlpha::GeneralisedAlpha(double rho) noexcept
    : alpha_m((2 * rho - 1) / (rho + 1)),
      alpha_f(rho / (rho + 1)),
      gamma(0.5 - alpha_m + alpha_f),
      beta(0.25 * (1 - alpha_m + alpha_f) * (1 - alpha_m + alpha_f)) {}

GeneralisedAlpha GeneralisedAlpha::hht(double alpha) noexcept {
  GeneralisedAlpha scheme(1);
  scheme.alpha_m = 0;
  scheme.alpha_f = -alpha;
  scheme.gamma = 0.5 - alpha;
  scheme.beta = 0.25 * (1 - alpha) * (1 - alpha);
  return scheme;
}

GeneralisedAlpha GeneralisedAlpha::newmark(double beta, double gamma) noexcept {
  GeneralisedAlpha scheme(1);
  scheme.alpha_m = scheme.alpha_f = 0;
  scheme.gamma = gamma;
  scheme.beta = beta;
  return scheme;
}

Integrator::Integrator(const Model& model, const Options& options, State start)
    : model_(model), options_(options), alpha_(options.scheme), assembler_(model, options.threads) {
  const std::size_t n = model.equation_count();
  if (options_.statics) alpha_.alpha_f = 0;
  u_m_.resize(n);
  v_m_.resize(n);
  residual_.resize(n);
  correction_.resize(n);
  reset(std::move(start));
}

void Integrator::reset(State state) {
  assert(state.u.size() == model_.equation_count());
  n_ = std::move(state);
  np1_ = n_;
}

double Integrator::load_factor(double time) const noexcept {
  if (!options_.ramp) return 1;
  return std::clamp((time - options_.ramp->begin) / (options_.ramp->end - options_.ramp->begin), 0.0, 1.0);
}

void Integrator::begin_step(double dt, Predictor predictor, bool completes) {
  dt_ = dt;
  step_error_.reset();
  auto at_n = evaluate_loads(model_, n_.time, load_factor(n_.time));
  auto at_np1 = evaluate_loads(model_, n_.time + dt, load_factor(n_.time + dt));
  auto held = held_motion(model_, n_.time + dt, held_difference * dt);
  if (!at_n) step_error_ = at_n.error();
  if (!at_np1) step_error_ = at_np1.error();
  if (!held) step_error_ = held.error();
  if (step_error_) return;
  loads_n_ = std::move(*at_n);
  loads_np1_ = std::move(*at_np1);
  loads_ = LoadValues::blend(loads_np1_, loads_n_, alpha_.alpha_f);
  held_ = std::move(*held);
  if (!n_.ledger.start) n_.ledger.start = kinetic_energy(n_) + static_residual(loads_n_, n_.u);
  np1_ = n_;
  np1_.time = n_.time + dt;
  np1_.step = n_.step + (completes ? 1 : 0);
  if (predictor == Predictor::extrapolate)
    for (std::size_t i = 0; i < np1_.u.size(); ++i) np1_.u[i] += dt * n_.v[i];
  update_rates();
  first_residual_ = -1;
  lu_.forget_pattern(); // its analysis looks at values: a step must not depend on the one before
}

void Integrator::set_interface_force(std::span<const double> force) {
  assert(force.size() == model_.equation_count());
  np1_.interface_force.assign(force.begin(), force.end());
}

void Integrator::set_displacement(std::span<const std::int32_t> nodes, std::span<const double> displacement) {
  assert(displacement.size() == 3 * nodes.size());
  for (std::size_t k = 0; k < nodes.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c)
      np1_.u[3 * static_cast<std::size_t>(nodes[k]) + c] = displacement[3 * k + c];
  update_rates();
}

void Integrator::apply_held() noexcept {
  for (const HeldMotion& held : held_) {
    np1_.u[held.equation] = held.u;
    np1_.v[held.equation] = options_.statics ? 0 : held.v;
    np1_.a[held.equation] = options_.statics ? 0 : held.a;
  }
}

void Integrator::update_rates() noexcept {
  const double beta = alpha_.beta, gamma = alpha_.gamma;
  for (std::size_t i = 0; i < np1_.u.size() && !options_.statics; ++i) {
    np1_.a[i] = (np1_.u[i] - n_.u[i] - dt_ * n_.v[i]) / (beta * dt_ * dt_) - (0.5 / beta - 1) * n_.a[i];
    np1_.v[i] = n_.v[i] + dt_ * ((1 - gamma) * n_.a[i] + gamma * np1_.a[i]);
  }
  apply_held();
}

double Integrator::interface_force(std::size_t i, double alpha_f) const noexcept {
  if (np1_.interface_force.empty()) return 0;
  if (n_.interface_force.empty()) return np1_.interface_force[i];
  return (1 - alpha_f) * np1_.interface_force[i] + alpha_f * n_.interface_force[i];
}

void Integrator::full_residual(const LoadValues& loads, double af, std::span<double> r, bool tangent) {
  const double am = alpha_.alpha_m, c = options_.mass_damping, tau = options_.stiffness_damping;
  const double by_velocity = options_.statics ? 0 : (1 - af) * alpha_.gamma / (alpha_.beta * dt_);
  for (std::size_t i = 0; i < u_m_.size(); ++i) {
    u_m_[i] = (1 - af) * np1_.u[i] + af * n_.u[i];
    v_m_[i] = (1 - af) * np1_.v[i] + af * n_.v[i];
  }
  if (tau > 0) {
    u_damped_ = u_m_;
    for (std::size_t i = 0; i < u_m_.size(); ++i) u_damped_[i] += tau * v_m_[i];
  }
  assembler_.assemble({.displacement = tau > 0 ? u_damped_ : u_m_,
                       .load_displacement = u_m_,
                       .loads = loads,
                       .tangent = tangent,
                       .tangent_scale = (1 - af) + tau * by_velocity,
                       .load_scale = 1 - af,
                       .load_stiffness = options_.newton.load_stiffness},
                      r);
  add_drag(model_,
           {.displacement = u_m_,
            .velocity = v_m_,
            .time = loads.time,
            .factor = loads.factor,
            .tangent = tangent ? &assembler_ : nullptr,
            .displacement_scale = 1 - af,
            .velocity_scale = by_velocity,
            .by_position = options_.newton.load_stiffness},
           r);
  for (std::size_t i = 0; i < r.size(); ++i) r[i] -= interface_force(i, af);
  if (options_.statics) return;
  for (std::size_t i = 0; i < r.size(); ++i)
    r[i] += model_.mass[i / 3] * ((1 - am) * np1_.a[i] + am * n_.a[i] + c * v_m_[i]);
  if (!tangent) return;
  const double inertia = (1 - am) / (alpha_.beta * dt_ * dt_) + c * by_velocity;
  for (std::size_t i = 0; i < model_.node_count(); ++i)
    assembler_.add_to_diagonal(static_cast<std::int32_t>(i), inertia * model_.mass[i]);
}

void Integrator::residual(std::span<double> r, bool tangent) {
  full_residual(loads_, alpha_.alpha_f, r, tangent);
  for (std::size_t i = 0; i < r.size(); ++i)
    if (model_.held[i]) r[i] = 0;
  if (tangent) assembler_.eliminate_held();
}

Result<void> Integrator::solve() {
  if (!options_.newton.load_stiffness) {
    const auto positive = cholesky_.factor(assembler_.tangent());
    if (!positive) return positive.error();
    if (*positive) return cholesky_.solve(residual_, correction_);
    lu_.forget_pattern();
  }
  const auto regular = lu_.factor(assembler_.tangent());
  if (!regular) return regular.error();
  if (!*regular)
    return retryable_error("the structure's tangent matrix is singular in the step to t = {}{}", np1_.time,
                           worst_nodes());
  return lu_.solve(residual_, correction_);
}

Error Integrator::not_finite(const char* what) const {
  return retryable_error("the structure's {} is not finite in the step to t = {}{}", what, np1_.time,
                         worst_nodes());
}

Result<void> Integrator::newton_iteration(Outcome& outcome) {
  if (step_error_) return *step_error_;
  residual(residual_, true);
  const double r = norm(residual_);
  if (!std::isfinite(r)) return not_finite("residual");
  if (first_residual_ < 0) first_residual_ = r;
  outcome.residual = first_residual_ > 0 ? r / first_residual_ : 0;
  DROGUE_TRY(solve());
  for (std::size_t i = 0; i < correction_.size(); ++i) np1_.u[i] -= correction_[i];
  update_rates();
  outcome.correction = largest_nodal(correction_);
  outcome.iterations += 1;
  return std::isfinite(outcome.correction) ? Result<void>() : not_finite("Newton correction");
}

bool Integrator::small(const Outcome& o) const noexcept {
  return o.correction < options_.newton.displacement_tolerance ||
         o.residual < options_.newton.residual_tolerance;
}

Result<Outcome> Integrator::iterate_to_tolerance() {
  Outcome outcome;
  while (!outcome.converged && outcome.iterations < options_.newton.max_iterations) {
    DROGUE_TRY(newton_iteration(outcome));
    outcome.converged = small(outcome);
  }
  return outcome;
}

Result<Outcome> Integrator::iterate(int count) {
  Outcome outcome;
  for (int k = 0; k < count; ++k) DROGUE_TRY(newton_iteration(outcome));
  outcome.converged = small(outcome);
  return outcome;
}

void Integrator::commit() {
  account_for_step();
  n_ = np1_;
}

} // namespace drogue::structure
