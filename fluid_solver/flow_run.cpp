// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/flow_run.hpp"

#include "common/la_krylov/session.hpp"
#include "common/mesh/msh.hpp"
#include "fluid_solver/flow_fields.hpp"

namespace drogue::fluid {
namespace {

constexpr const char* probe_array = "probe_positions";

void check_participant(const Settings& s, config::Report& report) {
  if (s.phases.size() > 1)
    report.error(s.source.where("phase[1]"),
                 fmt::format("a participant needs exactly one phase, this config has {}", s.phases.size()));
  for (std::size_t i = 0; i < s.phases.size(); ++i) {
    const std::string path = fmt::format("phase[{}].", i);
    if (s.phases[i].formulation != Formulation::dsd_sst)
      report.error(s.source.where(path + "formulation"), "a participant needs formulation: DSD_SST");
    if (s.phases[i].mesh_displacement)
      report.error(s.source.where(path + "mesh_displacement"),
                   "mesh_displacement is ignored by a participant, whose mesh the mesh mover moves: leave it "
                   "out");
  }
  if (s.interface.empty())
    report.error(s.source.where("interface"),
                 "a participant needs interface: the boundaries that the structure moves");
  if (s.remesh)
    report.error(
        s.source.where("remesh"),
        "remesh is ignored by a participant, whose mesh the mesh mover judges: give it to the mesh mover");
  if (s.final_state)
    report.error(s.source.where("final_state"),
                 "final_state is ignored by a participant, whose states the coupler keeps: leave it out");
}

} // namespace

Result<std::unique_ptr<Case>> load_case(const std::filesystem::path& file, Role role) {
  config::Report report;
  auto input = std::make_unique<Case>();
  input->settings = load_settings(file, report);
  const Settings& s = input->settings;
  if (!s.source.parsed()) return report.as_error();
  if (role == Role::participant) check_participant(s, report);
  if (s.mesh.empty() || !std::filesystem::is_regular_file(s.mesh)) return report.as_error();
  auto read = mesh::read_msh(s.mesh);
  if (!read) {
    report.error(s.source.where("mesh"), read.error().message);
    return report.as_error();
  }
  auto made = FluidMesh::create(std::move(*read));
  if (!made) {
    report.error(s.source.where("mesh"), fmt::format("{}: {}", s.mesh.string(), made.error().message));
    return report.as_error();
  }
  input->mesh = std::move(*made);
  check_against_mesh(s, input->mesh, report);
  if (const auto probes = Probes::create(s.probes, input->mesh); !probes)
    report.error(s.source.where("probe"), probes.error().message);
  if (!report.ok()) return report.as_error();
  return input;
}

Result<void> FlowRun::start() {
  const Settings& settings = input_.settings;
  if (settings.initial_state) {
    const auto file = io::read_state(*settings.initial_state);
    if (!file) return file.error();
    const auto done =
        settings.initial_state_mesh ? start_from_other_mesh(*file) : solver_->import_state(*file);
    const bool unnamed = file->mesh_hash != input_.mesh.hash && !settings.initial_state_mesh;
    if (!done)
      return config_error("{}: {}{}", settings.initial_state->string(), done.error().message,
                          unnamed ? "; name its mesh as initial_state_mesh" : "");
  }
  return settings.project_initial_flow ? solver_->project_velocity() : Result<void>();
}

Result<void> FlowRun::start_from_other_mesh(const io::State& file) {
  auto read = mesh::read_msh(*input_.settings.initial_state_mesh);
  if (!read) return read.error();
  const auto from = FluidMesh::create(std::move(*read));
  if (!from)
    return config_error("{}: {}", input_.settings.initial_state_mesh->string(), from.error().message);
  const auto there = flow_state_of(file, *from, input_.settings.density);
  if (!there) return there.error();
  auto here = interpolated(*there, *from, input_.mesh);
  if (!here) return here.error();
  solver_->set_state(std::move(*here));
  return {};
}

Result<void> FlowRun::import_state(const io::State& file) {
  DROGUE_TRY(solver_->import_state(file));
  const auto by_nodes = [&](int components) {
    return [this, components](std::span<const double> v) {
      return input_.mesh.reordered_from_file(v, components);
    };
  };
  averages_.velocity.load("velocity", file, by_nodes(3));
  averages_.pressure.load("pressure", file, by_nodes(1));
  averages_.forces.load("forces", file, [](const std::vector<double>& v) { return v; });
  const io::StateArray* probes = file.find(probe_array);
  if (probes == nullptr) return {};
  probe_positions_.clear();
  for (std::size_t i = 0; i + 2 < probes->values.size(); i += 3)
    probe_positions_.push_back({probes->values[i], probes->values[i + 1], probes->values[i + 2]});
  return la::agree(results_ ? results_->place_probes(input_.mesh, probe_positions_) : Result<void>());
}

void FlowRun::average(const StepFigures& figures) {
  const FlowState& s = solver_->state();
  const double dt = solver_->step_data().dt;
  const auto from = input_.settings.average_from;
  if (!from || s.time - 0.5 * dt < *from) return;
  averages_.velocity.add(dt, s.u);
  averages_.pressure.add(dt, s.p);
  std::vector<double> totals;
  for (const SurfaceForce& force : figures.forces)
    for (const double value : force.total()) totals.push_back(value);
  averages_.forces.add(dt, totals);
}

Result<void> FlowRun::open_results(const std::filesystem::path& directory, io::Existing existing) {
  Result<void> done;
  if (la::rank() == 0) {
    auto made = Results::create(input_.settings, input_.mesh, directory, existing);
    if (made)
      results_.emplace(std::move(*made));
    else
      done = made.error();
  }
  DROGUE_TRY(la::agree(done));
  fields_.emplace(input_.settings, input_.mesh, directory);
  return {};
}

Result<StepFigures> FlowRun::finish_step(bool write_fields, double failure_tolerance) {
  const auto newton = solver_->finish();
  if (!newton) return newton.error();
  if (!newton->converged && newton->residual > failure_tolerance)
    return numerical_error(
        "after {} Newton iterations the residual is {:.2e} of the first (the worst was {:.2e}), above "
        "failure_tolerance {:.2e}; use a smaller step",
        newton->iterations, newton->residual, newton->worst, failure_tolerance);
  StepFigures figures;
  figures.newton = *newton;
  figures.forces = surface_forces(input_.settings, input_.mesh, *solver_);
  solver_->commit();
  average(figures);
  Result<void> written;
  if (results_) {
    const FlowState& s = solver_->state();
    figures.cfl = largest_cfl(input_.mesh, s.x, s.u, solver_->step_data().dt);
    std::vector<double> relative = s.u;
    const StepData& data = solver_->step_data();
    for (std::size_t i = 0; i < relative.size(); ++i) relative[i] -= (data.x_np1[i] - data.x_n[i]) / data.dt;
    figures.mass_imbalance = mass_imbalance(input_.mesh, s.x, relative);
    written = results_->write_series(s, figures);
    if (written) written = results_->write_averages(averages_);
  }
  if (const auto all = la::agree(written); !all) return all.error();
  if (fields_ && write_fields)
    if (const auto all = fields_->write(solver_->state(), averages_, false); !all) return all.error();
  return figures;
}

Result<void> FlowRun::write_last_fields() {
  return fields_ ? fields_->write(solver_->state(), averages_, true) : Result<void>();
}

Result<void> FlowRun::write_state(const std::filesystem::path& file) {
  if (la::rank() != 0) return la::agree({});
  io::State state = solver_->export_state();
  const auto by_nodes = [&](int components) {
    return [this, components](std::span<const double> v) {
      return input_.mesh.reordered_to_file(v, components);
    };
  };
  averages_.velocity.save("velocity", state, by_nodes(3));
  averages_.pressure.save("pressure", state, by_nodes(1));
  averages_.forces.save("forces", state, [](const std::vector<double>& v) { return v; });
  if (!probe_positions_.empty()) {
    std::vector<double> flat;
    for (const auto& position : probe_positions_) flat.insert(flat.end(), position.begin(), position.end());
    state.add(probe_array, {probe_positions_.size(), 3}, std::move(flat));
  }
  return la::agree(io::write_state(file, state));
}

Result<void> FlowRun::save_positions(const std::filesystem::path& file) {
  return la::agree(results_ ? results_->save_positions(file, fields_->collection()) : Result<void>());
}

Result<void> FlowRun::restore_positions(const std::filesystem::path& file) {
  return la::agree(results_ ? results_->restore_positions(file, fields_->collection()) : Result<void>());
}

} // namespace drogue::fluid
