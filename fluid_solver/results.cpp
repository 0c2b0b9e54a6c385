// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/results.hpp"

#include <fmt/format.h>

#include "common/io/atomic_file.hpp"
#include "fluid_solver/flow_fields.hpp"

namespace drogue::fluid {
namespace {

std::vector<std::string> force_columns(const Settings& settings) {
  std::vector<std::string> columns{"time"};
  for (const ForceSettings& force : settings.forces) {
    for (const char* part : {"pressure", "viscous", "total", "moment", "reaction"})
      for (const char* axis : {"x", "y", "z"})
        columns.push_back(fmt::format("{}_{}_{}", force.name, part, axis));
    if (force.reference_force > 0)
      for (const char* axis : {"x", "y", "z"})
        columns.push_back(fmt::format("{}_coefficient_{}", force.name, axis));
  }
  return columns;
}

std::vector<std::string> probe_columns(const Settings& settings) {
  std::vector<std::string> columns{"time"};
  for (const ProbeSettings& probe : settings.probes)
    for (const char* value : {"u_x", "u_y", "u_z", "p"})
      columns.push_back(fmt::format("{}_{}", probe.name, value));
  return columns;
}

} // namespace

Result<Results> Results::create(const Settings& settings, const FluidMesh& mesh,
                                const std::filesystem::path& directory, io::Existing existing) {
  std::error_code failed;
  std::filesystem::create_directories(directory, failed);
  if (failed) return config_error("cannot create the folder {}: {}", directory.string(), failed.message());
  Results results(settings, mesh);
  results.directory_ = directory;
  results.collection_ = io::PvdCollection(directory / "fluid.pvd");
  auto flow = io::CsvWriter::create(
      directory / "flow.csv",
      {"step", "time", "newton_iterations", "residual", "gmres_iterations", "max_cfl", "mass_imbalance"},
      existing);
  if (!flow) return flow.error();
  results.flow_ = std::move(*flow);
  auto forces = io::CsvWriter::create(directory / "forces.csv", force_columns(settings), existing);
  if (!forces) return forces.error();
  results.forces_ = std::move(*forces);
  auto probes = Probes::create(settings, mesh);
  if (!probes) return probes.error();
  results.probes_ = std::move(*probes);
  if (!settings.probes.empty()) {
    auto series = io::CsvWriter::create(directory / "probes.csv", probe_columns(settings), existing);
    if (!series) return series.error();
    results.probe_series_.emplace(std::move(*series));
  }
  return results;
}

io::ResultFiles Results::files() {
  io::ResultFiles files{{&flow_, &forces_}, {&collection_}};
  if (probe_series_) files.series.push_back(&*probe_series_);
  return files;
}

Result<void> Results::save_positions(const std::filesystem::path& file) {
  return io::save_positions(file, files());
}

Result<void> Results::restore_positions(const std::filesystem::path& file) {
  return io::restore_positions(file, files());
}

Result<void> Results::write_series(const FlowState& state, const StepFigures& f) {
  std::vector<double> row{state.time};
  if (probe_series_) { // every step
    const std::vector<double> values = probes_.values(state.u, state.p, settings_->density);
    row.insert(row.end(), values.begin(), values.end());
    DROGUE_TRY(probe_series_->row(row));
  }
  if (state.step % static_cast<std::uint64_t>(settings_->output.series_interval) != 0) return {};
  DROGUE_TRY(flow_.row({static_cast<double>(state.step), state.time, static_cast<double>(f.newton.iterations),
                        f.newton.residual, static_cast<double>(f.newton.linear_iterations), f.cfl,
                        f.mass_imbalance}));
  row = {state.time};
  for (std::size_t i = 0; i < f.forces.size(); ++i) {
    const SurfaceForce& force = f.forces[i];
    const std::array<double, 3> total = force.total();
    for (const auto* part : {&force.pressure, &force.viscous, &total, &force.moment, &force.reaction})
      row.insert(row.end(), part->begin(), part->end());
    if (const double reference = settings_->forces[i].reference_force; reference > 0)
      for (std::size_t d = 0; d < 3; ++d) row.push_back(total[d] / reference);
  }
  return forces_.row(row);
}

Result<void> Results::write_averages(const FieldAverages& averages) const {
  if (averages.forces.empty()) return {};
  std::string text = "force,time,mean_x,mean_y,mean_z,rms_x,rms_y,rms_z\n";
  const std::vector<double>& mean = averages.forces.mean();
  const std::vector<double> rms = averages.forces.rms();
  for (std::size_t i = 0; i < settings_->forces.size(); ++i)
    text += fmt::format("{},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g}\n",
                        settings_->forces[i].name, averages.forces.weight(), mean[3 * i], mean[3 * i + 1],
                        mean[3 * i + 2], rms[3 * i], rms[3 * i + 1], rms[3 * i + 2]);
  return io::write_file(directory_ / "averages.csv", text);
}

Result<void> Results::write_fields(const FlowState& state, const FieldAverages& averages, bool force) {
  const auto interval = static_cast<std::uint64_t>(settings_->output.field_interval);
  if (interval == 0 || last_field_step_ == state.step) return {};
  if (!force && state.step % interval != 0) return {};
  const NodalFields nodal = nodal_fields(*settings_, *mesh_, state.x, state.u);
  const auto in_file_order = [&](std::span<const double> values, int components, double factor = 1) {
    std::vector<double> out = mesh_->reordered_to_file(values, components);
    for (double& value : out) value *= factor;
    return out;
  };
  const double rho = settings_->density;
  const std::vector<double> points = in_file_order(state.x, 3);
  const std::vector<double> u = in_file_order(state.u, 3);
  const std::vector<double> p = in_file_order(state.p, 1, rho);
  const std::vector<double> vorticity = in_file_order(nodal.vorticity, 3);
  const std::vector<double> q = in_file_order(nodal.q, 1);
  const std::vector<double> eddy = in_file_order(nodal.eddy, 1, rho);
  io::VtuData data;
  data.points = points;
  for (const mesh::ElementBlock& block : mesh_->file.blocks)
    if (mesh::dimension(block.kind) == mesh_->dimension) data.blocks.push_back(&block);
  data.point_data = {{"velocity", 3, u},
                     {"pressure", 1, p},
                     {"vorticity", 3, vorticity},
                     {"Q", 1, q},
                     {"eddy_viscosity", 1, eddy}};
  std::vector<double> displacement = points;
  for (std::size_t i = 0; i < displacement.size(); ++i) displacement[i] -= mesh_->file.points[i];
  data.point_data.push_back({"mesh_displacement", 3, displacement});
  std::vector<double> means[4];
  if (!averages.velocity.empty()) {
    means[0] = in_file_order(averages.velocity.mean(), 3);
    means[1] = in_file_order(averages.velocity.rms(), 3);
    means[2] = in_file_order(averages.pressure.mean(), 1, rho);
    means[3] = in_file_order(averages.pressure.rms(), 1, rho);
    data.point_data.insert(data.point_data.end(), {{"velocity_mean", 3, means[0]},
                                                   {"velocity_rms", 3, means[1]},
                                                   {"pressure_mean", 1, means[2]},
                                                   {"pressure_rms", 1, means[3]}});
  }
  const std::filesystem::path file = directory_ / fmt::format("fluid_{:06}.vtu", state.step);
  DROGUE_TRY(io::write_vtu(file, data));
  last_field_step_ = state.step;
  return collection_.add(state.time, file);
}

} // namespace drogue::fluid
