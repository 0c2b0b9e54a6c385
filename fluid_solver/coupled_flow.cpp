// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/coupled_flow.hpp"

#include <algorithm>

#include "common/la_krylov/session.hpp"
#include "fluid_solver/consistent_traction.hpp"
#include "fluid_solver/flow_fields.hpp"

namespace drogue::fluid {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

constexpr const char* state_file = "fluid.state";
constexpr const char* positions_file = "results.state";

} // namespace

void broadcast(Order& order) {
  auto kind = static_cast<std::uint64_t>(order.kind);
  la::broadcast_passively(&kind, sizeof(kind));
  order.kind = static_cast<Order::Kind>(kind);
  la::broadcast_passively(order.numbers);
  std::uint64_t length = order.text.size();
  la::broadcast_passively(&length, sizeof(length));
  order.text.resize(length);
  la::broadcast_passively(order.text.data(), length);
}

CoupledFlow::CoupledFlow(Case& input) : input_(input), run_(input) {
  find_interface();
}

void CoupledFlow::find_interface() {
  interface_file_nodes_.clear();
  const auto boundaries = boundary_indices(input_.mesh, input_.settings.interface);
  for (const std::int32_t node : input_.mesh.nodes_of(boundaries))
    interface_file_nodes_.push_back(input_.mesh.to_file[at(node)]);
  std::sort(interface_file_nodes_.begin(), interface_file_nodes_.end());
}

Result<void> CoupledFlow::execute(const Order& order) {
  switch (order.kind) {
  case Order::Kind::configure:
    resume_ = !order.numbers.empty() && order.numbers[0] != 0;
    return run_.open_results(order.text, resume_ ? io::Existing::keep : io::Existing::replace);
  case Order::Kind::initialize:
    return initialize();
  case Order::Kind::begin_step:
    run_.solver().set_clock(order.numbers[0], static_cast<std::uint64_t>(order.numbers[2]) - 1);
    return run_.solver().begin_step({Formulation::dsd_sst, 1, input_.settings.phases.front().time_points},
                                    order.numbers[1]);
  case Order::Kind::iterate:
    return iterate(order.numbers);
  case Order::Kind::commit: {
    const auto figures = run_.finish_step(order.numbers[0] != 0);
    advanced_ = true;
    return figures ? Result<void>() : figures.error();
  }
  case Order::Kind::rollback:
    run_.solver().rollback();
    return {};
  case Order::Kind::checkpoint:
    DROGUE_TRY(run_.write_state(std::filesystem::path(order.text) / state_file));
    return run_.save_positions(std::filesystem::path(order.text) / positions_file);
  case Order::Kind::restore:
    return restore(order.text);
  case Order::Kind::replace_mesh:
    return replace_mesh(order);
  case Order::Kind::stop:
    return advanced_ ? run_.write_last_fields() : Result<void>();
  }
  return internal_error("unknown order");
}

Result<void> CoupledFlow::initialize() {
  DROGUE_TRY(run_.start());
  base_points_ = run_.solver().state().x;
  if (base_points_ != input_.mesh.points)
    return config_error(
        "the initial state lives on a moved mesh; a coupled run starts from the mesh file's positions, as "
        "the mesh mover does");
  return {};
}

Result<void> CoupledFlow::replace_mesh(const Order& order) {
  const auto end = order.text.find('\n');
  auto defects =
      run_.replace_mesh(order.text.substr(end + 1), order.text.substr(0, end), order.numbers[0] != 0);
  if (!defects) return defects.error();
  defects_ = *defects;
  find_interface();
  base_points_ = input_.mesh.points;
  return {};
}

Result<void> CoupledFlow::restore(const std::string& directory) {
  const auto file = io::read_state(std::filesystem::path(directory) / state_file);
  if (!file) return file.error();
  DROGUE_TRY(run_.import_state(*file));
  if (resume_) DROGUE_TRY(run_.restore_positions(std::filesystem::path(directory) / positions_file));
  advanced_ = true;
  return {};
}

Result<void> CoupledFlow::iterate(const std::vector<double>& numbers) {
  FlowSolver& solver = run_.solver();
  const StepData& data = solver.step_data();
  const std::size_t n3 = base_points_.size();
  const std::size_t k3 = 3 * interface_file_nodes_.size();
  const std::span all(numbers);
  // 1. the mesh at t_{n+1}
  std::vector<double> x = input_.mesh.reordered_from_file(all.subspan(1, n3), 3);
  for (std::size_t i = 0; i < n3; ++i) x[i] += base_points_[i];
  // 2. walls: the mesh's own rate, on the interface what the structure says
  std::vector<double> wall_np1(n3);
  for (std::size_t i = 0; i < n3; ++i) wall_np1[i] = (x[i] - data.x_n[i]) / data.dt;
  std::vector<double> wall_n = wall_np1;
  const auto velocity = all.subspan(1 + n3, k3);
  const bool has_start = numbers[0] != 0;
  for (std::size_t k = 0; k < interface_file_nodes_.size(); ++k)
    for (std::size_t d = 0; d < 3; ++d) {
      const std::size_t i = 3 * at(input_.mesh.from_file[at(interface_file_nodes_[k])]) + d;
      wall_np1[i] = velocity[3 * k + d];
      wall_n[i] = has_start ? all[1 + n3 + k3 + 3 * k + d] : solver.state().wall_velocity[i];
    }
  DROGUE_TRY(solver.set_end(x, wall_n, wall_np1));
  // 3. Newton, from the last iterate of this step; never none, or small changes of the wall would go
  // unanswered
  auto report = solver.newton(input_.settings.newton.iterations_per_coupling, true);
  if (!report) return report.error();
  report_ = *report;
  if (input_.settings.interface_load != InterfaceLoad::consistent_traction) return {};
  // 4. the residual of the last iterate
  if (const auto last = solver.finish(); !last) return last.error();
  forces_ = nodal_forces(input_.settings, input_.mesh, solver);
  mean_forces_ = mean_nodal_forces(input_.settings, input_.mesh, solver);
  return {};
}

Result<std::vector<double>> CoupledFlow::load() const {
  const auto& solver = run_.solver();
  std::vector<double> out;
  if (input_.settings.interface_load == InterfaceLoad::pressure) {
    const std::vector<double> p = solver.pressure_np1();
    for (const std::int32_t node : interface_file_nodes_)
      out.push_back(input_.settings.density * p[at(input_.mesh.from_file[at(node)])]);
    return out;
  }
  return traction(solver.velocity_np1(), solver.pressure_np1(), forces_);
}

Result<std::vector<double>> CoupledFlow::mean_traction() const {
  const auto& solver = run_.solver();
  std::vector<double> u = solver.velocity_np1();
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = 0.5 * (u[i] + solver.state().u[i]);
  return traction(u, solver.pressure_mean(), mean_forces_);
}

/// From velocity and pressure, or for the consistent traction from nodal forces; on the mesh at t_{n+1}.
Result<std::vector<double>> CoupledFlow::traction(const std::vector<double>& u, const std::vector<double>& p,
                                                  const std::vector<double>& forces) const {
  const auto boundaries = boundary_indices(input_.mesh, input_.settings.interface);
  const std::vector<std::int32_t> nodes = input_.mesh.nodes_of(boundaries);
  const std::vector<double>& x = run_.solver().step_data().x_np1;
  std::vector<double> t, out;
  if (input_.settings.interface_load == InterfaceLoad::traction) {
    t = nodal_traction(input_.settings, input_.mesh, x, u, p, boundaries, nodes);
    for (double& value : t) value *= input_.settings.density;
  } else {
    auto made = traction_of(forces, input_.mesh, x, boundaries, nodes);
    if (!made) return made.error();
    t = std::move(*made);
  }
  for (const std::int32_t node : interface_file_nodes_) {
    const auto k = static_cast<std::size_t>(
        std::lower_bound(nodes.begin(), nodes.end(), input_.mesh.from_file[at(node)]) - nodes.begin());
    for (std::size_t d = 0; d < 3; ++d) out.push_back(t[3 * k + d]);
  }
  return out;
}

std::vector<double> CoupledFlow::mean_pressure() const {
  const std::vector<double> p = run_.solver().pressure_mean();
  std::vector<double> out;
  for (const std::int32_t node : interface_file_nodes_)
    out.push_back(input_.settings.density * p[at(input_.mesh.from_file[at(node)])]);
  return out;
}

} // namespace drogue::fluid
