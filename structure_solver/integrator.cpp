// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/integrator.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace drogue::structure {
namespace {

double norm(std::span<const double> x) noexcept {
  double sum = 0;
  for (const double value : x) sum += value * value;
  return std::sqrt(sum);
}

double largest_nodal(std::span<const double> x) noexcept {
  double largest = 0;
  for (std::size_t i = 0; i + 2 < x.size(); i += 3)
    largest = std::max(largest, x[i] * x[i] + x[i + 1] * x[i + 1] + x[i + 2] * x[i + 2]);
  return std::sqrt(largest);
}

} // namespace

State rest_state(const Model& model) {
  const std::vector<double> zero(model.equation_count(), 0.0);
  return {0, 0, zero, zero, zero, {}};
}

GeneralisedAlpha GeneralisedAlpha::from_rho(double rho) noexcept {
  const double m = (2 * rho - 1) / (rho + 1), f = rho / (rho + 1);
  return {m, f, 0.5 - m + f, 0.25 * (1 - m + f) * (1 - m + f)};
}

Integrator::Integrator(const Model& model, const Options& options, State start)
    : model_(model),
      options_(options),
      alpha_(GeneralisedAlpha::from_rho(options.rho_infinity)),
      assembler_(model, options.threads) {
  const std::size_t n = model.equation_count();
  u_m_.resize(n);
  residual_.resize(n);
  correction_.resize(n);
  reset(std::move(start));
}

void Integrator::reset(State state) {
  assert(state.u.size() == model_.equation_count());
  n_ = std::move(state);
  np1_ = n_;
}

void Integrator::begin_step(double dt, Predictor predictor) {
  dt_ = dt;
  np1_ = n_;
  np1_.time = n_.time + dt;
  np1_.step = n_.step + 1;
  if (predictor == Predictor::extrapolate)
    for (std::size_t i = 0; i < np1_.u.size(); ++i) np1_.u[i] += dt * n_.v[i];
  hold_supports(np1_.time);
  update_rates();
  loads_ =
      LoadValues::blend(evaluate_loads(model_, np1_.time), evaluate_loads(model_, n_.time), alpha_.alpha_f);
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
  hold_supports(np1_.time);
  update_rates();
}

void Integrator::hold_supports(double time) {
  for (const SupportSet& support : model_.supports)
    for (const std::int32_t node : support.nodes) {
      const std::size_t i = 3 * static_cast<std::size_t>(node);
      const double* X = &model_.mesh.points[i];
      for (std::size_t c = 0; c < 3; ++c)
        if (support.held[c]) np1_.u[i + c] = support.displacement[c](X[0], X[1], X[2], time);
    }
}

void Integrator::update_rates() noexcept {
  const double beta = alpha_.beta, gamma = alpha_.gamma;
  for (std::size_t i = 0; i < np1_.u.size(); ++i) {
    np1_.a[i] = (np1_.u[i] - n_.u[i] - dt_ * n_.v[i]) / (beta * dt_ * dt_) - (0.5 / beta - 1) * n_.a[i];
    np1_.v[i] = n_.v[i] + dt_ * ((1 - gamma) * n_.a[i] + gamma * np1_.a[i]);
  }
}

void Integrator::residual(std::span<double> r, bool tangent) {
  const double am = alpha_.alpha_m, af = alpha_.alpha_f, c = options_.mass_damping;
  for (std::size_t i = 0; i < u_m_.size(); ++i) u_m_[i] = (1 - af) * np1_.u[i] + af * n_.u[i];
  assembler_.assemble({.displacement = u_m_,
                       .loads = loads_,
                       .tangent = tangent,
                       .tangent_scale = 1 - af,
                       .load_stiffness = options_.newton.load_stiffness},
                      r);
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double a_m = (1 - am) * np1_.a[i] + am * n_.a[i], v_m = (1 - af) * np1_.v[i] + af * n_.v[i];
    r[i] += model_.mass[i / 3] * (a_m + c * v_m);
  }
  if (!np1_.interface_force.empty()) {
    const bool first = n_.interface_force.empty();
    for (std::size_t i = 0; i < r.size(); ++i) {
      const double f_np1 = np1_.interface_force[i];
      r[i] -= first ? f_np1 : (1 - af) * f_np1 + af * n_.interface_force[i];
    }
  }
  for (std::size_t i = 0; i < r.size(); ++i)
    if (model_.held[i]) r[i] = 0;
  if (!tangent) return;
  const double inertia =
      (1 - am) / (alpha_.beta * dt_ * dt_) + (1 - af) * c * alpha_.gamma / (alpha_.beta * dt_);
  for (std::size_t i = 0; i < model_.node_count(); ++i)
    assembler_.add_to_diagonal(static_cast<std::int32_t>(i), inertia * model_.mass[i]);
  assembler_.eliminate_held();
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
    return retryable_error("the structure's tangent matrix is singular in the step to t = {}", np1_.time);
  return lu_.solve(residual_, correction_);
}

Result<void> Integrator::newton_iteration(Outcome& outcome) {
  residual(residual_, true);
  const double r = norm(residual_);
  if (!std::isfinite(r))
    return retryable_error("the structure's residual is not finite in the step to t = {}", np1_.time);
  if (first_residual_ < 0) first_residual_ = r;
  outcome.residual = first_residual_ > 0 ? r / first_residual_ : 0;
  DROGUE_TRY(solve());
  for (std::size_t i = 0; i < correction_.size(); ++i) np1_.u[i] -= correction_[i];
  update_rates();
  outcome.correction = largest_nodal(correction_);
  outcome.iterations += 1;
  if (!std::isfinite(outcome.correction))
    return retryable_error("the structure's Newton correction is not finite in the step to t = {}",
                           np1_.time);
  return {};
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
  n_ = np1_;
}

void Integrator::balance_start() {
  const LoadValues loads = evaluate_loads(model_, n_.time);
  assembler_.assemble({.displacement = n_.u, .loads = loads}, residual_);
  for (std::size_t i = 0; i < residual_.size(); ++i)
    n_.a[i] = model_.held[i] ? 0.0 : -residual_[i] / model_.mass[i / 3] - options_.mass_damping * n_.v[i];
  np1_ = n_;
}

Balance Integrator::balance() {
  Balance b;
  LoadValues loads = evaluate_loads(model_, n_.time);
  for (std::size_t i = 0; i < n_.interface_force.size(); ++i) loads.force[i] += n_.interface_force[i];
  b.strain_energy = assembler_.assemble({.displacement = n_.u, .loads = loads}, residual_);
  assembler_.external_force(n_.u, loads, correction_);
  double unbalanced = 0;
  for (std::size_t i = 0; i < residual_.size(); ++i) {
    const double m = model_.mass[i / 3];
    b.kinetic_energy += 0.5 * m * n_.v[i] * n_.v[i];
    if (!model_.held[i]) unbalanced += residual_[i] * residual_[i];
  }
  const double applied = norm(correction_);
  // Without an applied load (prestress, moved supports) the forces of the held nodes are the measure.
  const double scale = applied > 0 ? applied : norm(residual_);
  b.unbalance = scale > 0 ? std::sqrt(unbalanced) / scale : 0;
  for (const SupportSet& support : model_.supports) {
    std::array<double, 3> sum{};
    for (const std::int32_t node : support.nodes)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t i = 3 * static_cast<std::size_t>(node) + c;
        if (!support.held[c]) continue;
        sum[c] += residual_[i] + model_.mass[i / 3] * (n_.a[i] + options_.mass_damping * n_.v[i]);
      }
    b.reactions.push_back(sum);
  }
  return b;
}

} // namespace drogue::structure
