// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/flow_solver.hpp"

#include <algorithm>
#include <cmath>

#include "fluid_solver/time_difference.hpp"

namespace drogue::fluid {
namespace {

std::vector<double> at_nodes(const config::VectorExpression& f, std::span<const double> x, double t) {
  std::vector<double> values(x.size(), 0.0);
  for (std::size_t d = 0; d < 3; ++d) {
    if (f[d].is_zero()) continue;
    for (std::size_t i = 0; i < x.size(); i += 3) values[i + d] = f[d](x[i], x[i + 1], x[i + 2], t);
  }
  return values;
}

double largest_norm(std::span<const double> values, std::size_t stride) {
  double largest = 0;
  for (std::size_t i = 0; i + 2 < values.size(); i += stride)
    largest = std::max(largest, std::hypot(values[i], values[i + 1], values[i + 2]));
  return largest;
}

/// A lagged Jacobian is evaluated anew when an iteration leaves more than this part of the residual.
constexpr double slow_reduction = 0.3;

/// Newton iterations of a slab of settle, at most.
constexpr int settling_iterations = 20;

bool uses_two_steps(const Settings& settings) {
  return std::any_of(settings.phases.begin(), settings.phases.end(), [](const PhaseSettings& phase) {
    return phase.formulation == Formulation::semi_discrete && phase.time_order == 2;
  });
}

double total_volume(const FluidMesh& mesh) {
  double sum = 0;
  for (std::int32_t e = 0; e < mesh.cell_count(); ++e) sum += cell_geometry(mesh, mesh.points, e).volume;
  return sum;
}

} // namespace

FlowSolver::FlowSolver(const Settings& settings, const FluidMesh& mesh)
    : settings_(settings), mesh_(mesh), constraints_(settings, mesh) {
  state_.x = mesh.points;
  state_.u = at_nodes(settings.initial_velocity, mesh.points, 0);
  state_.wall_velocity.assign(mesh.points.size(), 0.0);
  for (std::size_t i = 0; i < mesh.points.size(); i += 3)
    state_.p.push_back(settings.initial_pressure(mesh.points[i], mesh.points[i + 1], mesh.points[i + 2], 0) /
                       settings.density);
}

io::State FlowSolver::export_state() const {
  io::State file{"fluid", mesh_.hash, state_.time, state_.step, {}};
  const auto n = static_cast<std::uint64_t>(mesh_.node_count());
  file.add("velocity", {n, 3}, mesh_.reordered_to_file(state_.u, 3));
  std::vector<double> p = mesh_.reordered_to_file(state_.p, 1);
  for (double& value : p) value *= settings_.density;
  file.add("pressure", {n}, std::move(p));
  // The exact kinematic pressure: a division after a product need not give the same bits.
  file.add("kinematic_pressure", {n}, mesh_.reordered_to_file(state_.p, 1));
  file.add("wall_velocity", {n, 3}, mesh_.reordered_to_file(state_.wall_velocity, 3));
  file.add("position", {n, 3}, mesh_.reordered_to_file(state_.x, 3));
  if (uses_two_steps(settings_) && !state_.u_before.empty()) {
    file.add("velocity_before", {n, 3}, mesh_.reordered_to_file(state_.u_before, 3));
    file.add("step_before", {1}, {state_.step_before});
  }
  return file;
}

Result<void> FlowSolver::import_state(const io::State& file) {
  auto state = flow_state_of(file, mesh_, settings_.density);
  if (!state) return state.error();
  state_ = std::move(*state);
  return {};
}

Result<void> FlowSolver::begin_step(const StepScheme& scheme, double dt) {
  auto& system = systems_[scheme.formulation == Formulation::dsd_sst ? 1 : 0];
  if (!system) {
    auto made = make_flow_system(scheme.formulation, settings_, mesh_, constraints_);
    if (!made) return made.error();
    system = std::move(*made);
  }
  active_ = system.get();
  data_.t_n = state_.time;
  data_.dt = dt;
  data_.x_n = data_.x_np1 = state_.x;
  data_.u_n = state_.u;
  data_.time_points = scheme.time_points;
  convection_ = scheme.convection;
  if (scheme.formulation == Formulation::semi_discrete) set_time_difference(scheme.time_order);
  data_.wall_n = data_.wall_np1 = state_.wall_velocity;
  data_.f_n = at_nodes(settings_.body_force, state_.x, state_.time);
  data_.f_np1 = at_nodes(settings_.body_force, state_.x, state_.time + dt);
  const auto n = static_cast<std::size_t>(active_->unknowns());
  data_.unknowns.resize(static_cast<std::size_t>(mesh_.node_count()) * n);
  for (std::size_t i = 0; i < state_.p.size(); ++i)
    for (std::size_t q = 0; q < n; q += 4) {
      std::copy_n(state_.u.data() + 3 * i, 3, data_.unknowns.data() + n * i + q);
      data_.unknowns[n * i + q + 3] = state_.p[i];
    }
  total_ = {};
  first_residual_.reset();
  updates_since_jacobian_ = -1;
  return {};
}

Result<void> FlowSolver::set_end(std::span<const double> x_np1, std::span<const double> wall_n,
                                 std::span<const double> wall_np1) {
  if (const double ratio = smallest_volume_ratio(mesh_, x_np1); !(ratio > 0))
    return retryable_error("the fluid mesh has an inverted element: smallest volume ratio {:.3g}", ratio);
  data_.x_np1.assign(x_np1.begin(), x_np1.end());
  data_.wall_n.assign(wall_n.begin(), wall_n.end());
  data_.wall_np1.assign(wall_np1.begin(), wall_np1.end());
  data_.f_np1 = at_nodes(settings_.body_force, data_.x_np1, data_.t_n + data_.dt);
  return {};
}

void FlowSolver::set_time_difference(int order) {
  const bool second = order == 2 && !state_.u_before.empty();
  const TimeDifference d = second ? two_step(data_.dt, state_.step_before) : backward_euler(data_.dt);
  data_.rate = d.rate;
  data_.history.resize(state_.u.size());
  for (std::size_t i = 0; i < state_.u.size(); ++i)
    data_.history[i] = d.at_n * state_.u[i] + (second ? d.before * state_.u_before[i] : 0.0);
}

void FlowSolver::apply_constraints() {
  const auto n = static_cast<std::size_t>(active_->unknowns());
  const double t_np1 = data_.t_n + data_.dt;
  if (n == 8) data_.slip_n = constraints_.apply(data_.t_n, data_.x_n, data_.wall_n, data_.unknowns, n, 0);
  data_.slip_np1 = constraints_.apply(t_np1, data_.x_np1, data_.wall_np1, data_.unknowns, n, n - 4);
}

void FlowSolver::recover_stress() {
  data_.stress_n.clear();
  data_.stress_np1.clear();
  if (!settings_.viscous_residual || !convection_) return;
  if (!recovered_) recovered_.emplace(mesh_, active_->own_rows());
  const auto n = static_cast<std::size_t>(active_->unknowns());
  const std::span<const double> w(data_.unknowns);
  const double nu = settings_.kinematic_viscosity();
  if (n == 8) recovered_->evaluate(data_.x_n, w, n, nu, data_.stress_n);
  recovered_->evaluate(data_.x_np1, w.subspan(n - 4), n, nu, data_.stress_np1);
}

/// U: the largest speed of the step's start; in a fluid at rest what the body force or one element a step
/// make.
void FlowSolver::set_scale() {
  const auto n = static_cast<std::size_t>(active_->unknowns());
  const double h = std::pow(total_volume(mesh_) / mesh_.cell_count(), 1.0 / mesh_.dimension);
  double speed = std::max(largest_norm(data_.unknowns, n), largest_norm(data_.u_n, 3));
  if (n == 8) speed = std::max(speed, largest_norm(std::span(data_.unknowns).subspan(4), n));
  if (speed == 0) speed = largest_norm(data_.f_np1, 3) * data_.dt;
  if (speed == 0) speed = h / data_.dt;
  active_->begin_step(data_.dt, speed, convection_);
  residual_floor_ = 1e-12 * speed * speed * std::pow(h, mesh_.dimension - 1) * std::sqrt(mesh_.node_count()) *
                    (n == 8 ? data_.dt : 1.0);
}

Result<double> FlowSolver::evaluate(bool jacobian) {
  apply_constraints();
  recover_stress();
  if (!first_residual_) set_scale();
  auto norm = active_->evaluate(data_, jacobian);
  if (!norm) {
    for (const auto& [t, x] :
         {std::pair{data_.t_n, &data_.x_n}, std::pair{data_.t_n + data_.dt, &data_.x_np1}})
      if (const std::string cause = constraints_.not_finite(t, *x); !cause.empty())
        return numerical_error("{}", cause);
    return norm;
  }
  if (!first_residual_) first_residual_ = *norm;
  total_.residual = *first_residual_ > 0 ? *norm / *first_residual_ : 0;
  total_.worst = std::max(total_.worst, total_.residual);
  total_.converged = total_.residual <= settings_.newton.residual_tolerance || *norm <= residual_floor_;
  return norm;
}

/// Solves for a correction and adds it; with line search, the half of it, a quarter, ... until the residual
/// is below what it was.
Result<la::Outcome> FlowSolver::correct(double residual) {
  const double shortest = settings_.newton.shortest_correction;
  if (shortest >= 1) return active_->solve_and_add(data_.unknowns);
  before_ = data_.unknowns;
  auto solved = active_->solve_and_add(data_.unknowns);
  if (!solved) return solved;
  for (double length = 1; length > shortest; length *= 0.5) {
    const auto norm = evaluate(false);
    if (norm.ok() && *norm < residual) break;
    for (std::size_t i = 0; i < before_.size(); ++i)
      data_.unknowns[i] = 0.5 * (data_.unknowns[i] + before_[i]);
  }
  return solved;
}

Result<void> FlowSolver::project_velocity() {
  const FlowState start = state_;
  const double h = std::pow(total_volume(mesh_) / mesh_.cell_count(), 1.0 / mesh_.dimension);
  const double speed = largest_norm(state_.u, 3);
  const double dt = 1e-3 * h / (speed > 0 ? speed : 1.0);
  DROGUE_TRY(begin_step({.formulation = Formulation::semi_discrete, .convection = false}, dt));
  const auto report = newton(20, true);
  if (!report) return report.error();
  if (!report->linear_converged || report->residual > 1e-6)
    return numerical_error(
        "the projection of the initial velocity does not converge: residual {:.1e} of the first",
        report->residual);
  commit();
  std::vector<double> u = std::move(state_.u);
  state_ = start;
  state_.u = std::move(u);
  return {};
}

Result<void> FlowSolver::settle(double dt, int time_points, int slabs) {
  for (int slab = 0; slab < slabs; ++slab) {
    DROGUE_TRY(begin_step({.formulation = Formulation::dsd_sst, .time_points = time_points}, dt));
    const auto report = newton(settling_iterations);
    if (!report) return report.error();
    if (!report->converged)
      return numerical_error(
          "the flow does not settle on its new mesh: residual {:.1e} of the first after {} iterations",
          report->residual, report->iterations);
    state_.u = velocity_np1();
    state_.p = pressure_np1();
  }
  return {};
}

Result<NewtonReport> FlowSolver::newton(int iterations, bool all) {
  NewtonReport report;
  double previous = 0;
  for (int k = 0; k < iterations; ++k) {
    bool jacobian = updates_since_jacobian_ < 0 || updates_since_jacobian_ >= settings_.newton.jacobian_lag;
    auto norm = evaluate(jacobian);
    if (!norm) return norm.error();
    if (!jacobian && !total_.converged && k > 0 && *norm > slow_reduction * previous) {
      jacobian = true; // the old Jacobian leads nowhere
      norm = evaluate(jacobian);
      if (!norm) return norm.error();
    }
    previous = *norm;
    if (jacobian) updates_since_jacobian_ = 0;
    if (all ? *norm <= residual_floor_ : total_.converged) break;
    const auto solved = correct(*norm);
    if (!solved) return solved.error();
    ++updates_since_jacobian_;
    ++report.iterations;
    report.linear_iterations += solved->iterations;
    report.linear_converged = report.linear_converged && solved->converged;
  }
  total_.iterations += report.iterations;
  total_.linear_iterations += report.linear_iterations;
  total_.linear_converged = total_.linear_converged && report.linear_converged;
  report.residual = total_.residual;
  report.converged = total_.converged;
  return report;
}

Result<NewtonReport> FlowSolver::finish() {
  if (const auto norm = evaluate(false); !norm) return norm.error();
  return total_;
}

void FlowSolver::commit() {
  state_.u_before = std::move(state_.u);
  state_.step_before = data_.dt;
  state_.u = velocity_np1();
  state_.p = pressure_np1();
  state_.x = data_.x_np1;
  state_.wall_velocity = data_.wall_np1;
  state_.time = data_.t_n + data_.dt;
  ++state_.step;
}

std::vector<double> FlowSolver::velocity_np1() const {
  const auto n = static_cast<std::size_t>(active_->unknowns());
  std::vector<double> u(data_.u_n.size());
  for (std::size_t i = 0; i < state_.p.size(); ++i)
    std::copy_n(data_.unknowns.data() + n * i + (n - 4), 3, u.data() + 3 * i);
  return u;
}

std::vector<double> FlowSolver::pressure_np1() const {
  const auto n = static_cast<std::size_t>(active_->unknowns());
  std::vector<double> p(state_.p.size());
  for (std::size_t i = 0; i < p.size(); ++i) p[i] = data_.unknowns[n * i + n - 1];
  return p;
}

std::vector<double> FlowSolver::pressure_mean() const {
  std::vector<double> p = pressure_np1();
  if (active_->unknowns() == 8)
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = 0.5 * (p[i] + data_.unknowns[8 * i + 3]);
  return p;
}

} // namespace drogue::fluid
