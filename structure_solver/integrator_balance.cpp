// SPDX-License-Identifier: GPL-3.0-or-later
//
// Forces and energies of the committed state, and what goes in and out in a step.
#include <algorithm>
#include <cmath>

#include "structure_solver/drag_assembly.hpp"
#include "structure_solver/integrator.hpp"
#include "structure_solver/norm.hpp"

namespace drogue::structure {

double Integrator::kinetic_energy(const State& state) const noexcept {
  double energy = 0;
  for (std::size_t i = 0; i < state.v.size(); ++i)
    energy += 0.5 * model_.mass[i / 3] * state.v[i] * state.v[i];
  return energy;
}

double Integrator::static_residual(const LoadValues& loads, std::span<const double> u) {
  const double energy =
      assembler_.assemble({.displacement = u, .load_displacement = n_.u, .loads = loads}, residual_);
  add_drag(model_, {.displacement = n_.u, .velocity = n_.v, .time = loads.time, .factor = loads.factor},
           residual_);
  for (std::size_t i = 0; i < n_.interface_force.size(); ++i) residual_[i] -= n_.interface_force[i];
  return energy;
}

void Integrator::balance_start() {
  const auto loads = evaluate_loads(model_, n_.time, load_factor(n_.time));
  if (!loads) return; // the first step reports it
  static_residual(*loads, n_.u);
  for (std::size_t i = 0; i < residual_.size(); ++i)
    if (!model_.held[i]) n_.a[i] = -residual_[i] / model_.mass[i / 3] - options_.mass_damping * n_.v[i];
  np1_ = n_;
}

std::array<double, 3> Integrator::external_force(const LoadValues& loads) {
  assembler_.external_force(n_.u, loads, correction_);
  std::fill(residual_.begin(), residual_.end(), 0.0);
  add_drag(model_, {.displacement = n_.u, .velocity = n_.v, .time = loads.time, .factor = loads.factor},
           residual_);
  std::array<double, 3> sum{};
  for (std::size_t i = 0; i < residual_.size(); ++i) sum[i % 3] += correction_[i] - residual_[i];
  return sum;
}

Balance Integrator::balance() {
  Balance b;
  const auto loads = evaluate_loads(model_, n_.time, load_factor(n_.time));
  if (!loads) return b;
  b.external_force = external_force(*loads);
  for (std::size_t i = 0; i < n_.interface_force.size(); ++i)
    b.interface_force[i % 3] += n_.interface_force[i];
  b.kinetic_energy = kinetic_energy(n_);
  b.strain_energy = static_residual(*loads, n_.u);
  b.ledger = n_.ledger;
  const EnergyLedger& l = n_.ledger;
  const double stored = b.kinetic_energy + b.strain_energy;
  b.energy_lost = l.start.value_or(stored) + l.external + l.support + l.actuator - l.damping - stored;

  std::vector<double>& applied = correction_;
  assembler_.external_force(n_.u, *loads, applied);
  for (std::size_t i = 0; i < n_.interface_force.size(); ++i) applied[i] += n_.interface_force[i];
  double unbalanced = 0;
  for (std::size_t i = 0; i < residual_.size(); ++i)
    if (!model_.held[i]) unbalanced += residual_[i] * residual_[i];
  const double load = norm(applied);
  // Without an applied load (prestress, moved supports) the forces of the held nodes are the measure.
  const double scale = load > 0 ? load : norm(residual_);
  b.unbalance = scale > 0 ? std::sqrt(unbalanced) / scale : 0;
  if (options_.stiffness_damping > 0) {
    u_damped_ = n_.u;
    for (std::size_t i = 0; i < u_damped_.size(); ++i) u_damped_[i] += options_.stiffness_damping * n_.v[i];
    static_residual(*loads, u_damped_);
  }
  for (const SupportSet& support : model_.supports) {
    std::array<double, 3> sum{};
    for (const std::int32_t node : support.nodes)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t i = 3 * static_cast<std::size_t>(node) + c;
        if (support.held[c])
          sum[c] += residual_[i] + model_.mass[i / 3] * (n_.a[i] + options_.mass_damping * n_.v[i]);
      }
    b.reactions.push_back(sum);
  }
  return b;
}

double Integrator::work_of_lengths() const {
  double work = 0;
  for (const LengthControl& control : model_.lengths) {
    const auto& lines = std::get<Batch<Line>>(model_.batches[control.batch]);
    const double change = loads_np1_.length_factor[control.batch] - loads_n_.length_factor[control.batch];
    if (change == 0) continue;
    const double factor =
        0.5 * (loads_np1_.length_factor[control.batch] + loads_n_.length_factor[control.batch]);
    for (std::size_t e = 0; e < lines.count(); ++e) {
      Line::Positions x;
      for (int a = 0; a < Line::nodes; ++a) {
        const std::size_t i = 3 * static_cast<std::size_t>(lines.element(e)[a]);
        for (std::size_t c = 0; c < 3; ++c)
          x(static_cast<int>(c), a) = model_.mesh.points[i + c] + 0.5 * (np1_.u[i + c] + n_.u[i + c]);
      }
      work += change * lines.reference[e].natural_length *
              Line::energy_by_length(at_length(lines.reference[e], factor), lines.material, x);
    }
  }
  return work;
}

double Integrator::work_of_damping(const LoadValues& loads) {
  double work = 0;
  const auto du = [&](std::size_t i) { return np1_.u[i] - n_.u[i]; };
  for (std::size_t i = 0; i < v_m_.size(); ++i)
    work += options_.mass_damping * model_.mass[i / 3] * v_m_[i] * du(i);
  if (!(options_.stiffness_damping > 0)) return work;
  u_damped_ = u_m_;
  for (std::size_t i = 0; i < u_m_.size(); ++i) u_damped_[i] += options_.stiffness_damping * v_m_[i];
  assembler_.assemble({.displacement = u_damped_, .load_displacement = u_m_, .loads = loads}, residual_);
  assembler_.assemble({.displacement = u_m_, .load_displacement = u_m_, .loads = loads}, correction_);
  for (std::size_t i = 0; i < residual_.size(); ++i) work += (residual_[i] - correction_[i]) * du(i);
  return work;
}

void Integrator::account_for_step() {
  // A static step has no intermediate time: the middle integrates the work to second order.
  const double af = options_.statics ? 0.5 : alpha_.alpha_f;
  const LoadValues loads = LoadValues::blend(loads_np1_, loads_n_, af);
  for (std::size_t i = 0; i < u_m_.size(); ++i) {
    u_m_[i] = (1 - af) * np1_.u[i] + af * n_.u[i];
    v_m_[i] = (1 - af) * np1_.v[i] + af * n_.v[i];
  }
  const auto du = [&](std::size_t i) { return np1_.u[i] - n_.u[i]; };
  EnergyLedger& ledger = np1_.ledger;

  // residual_ = -(loads + drag)
  assembler_.external_force(u_m_, loads, residual_);
  for (double& f : residual_) f = -f;
  add_drag(model_, {.displacement = u_m_, .velocity = v_m_, .time = loads.time, .factor = loads.factor},
           residual_);
  for (std::size_t i = 0; i < residual_.size(); ++i)
    ledger.external += (interface_force(i, af) - residual_[i]) * du(i);

  ledger.actuator += work_of_lengths();
  if (options_.mass_damping > 0 || options_.stiffness_damping > 0) ledger.damping += work_of_damping(loads);

  bool moved = false;
  for (const HeldMotion& held : held_) moved = moved || du(held.equation) != 0;
  if (!moved) return;
  full_residual(loads, af, residual_, false);
  for (const HeldMotion& held : held_) ledger.support += residual_[held.equation] * du(held.equation);
}

} // namespace drogue::structure
