// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/results.hpp"

#include <fmt/format.h>

#include "common/io/atomic_file.hpp"

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
  Results results(settings);
  results.directory_ = directory;
  auto flow = io::CsvWriter::create(
      directory / "flow.csv",
      {"step", "time", "newton_iterations", "residual", "gmres_iterations", "max_cfl", "mass_imbalance"},
      existing);
  if (!flow) return flow.error();
  results.flow_ = std::move(*flow);
  auto forces = io::CsvWriter::create(directory / "forces.csv", force_columns(settings), existing);
  if (!forces) return forces.error();
  results.forces_ = std::move(*forces);
  auto probes = Probes::create(settings.probes, mesh);
  if (!probes) return probes.error();
  results.probes_ = std::move(*probes);
  if (!settings.probes.empty()) {
    auto series = io::CsvWriter::create(directory / "probes.csv", probe_columns(settings), existing);
    if (!series) return series.error();
    results.probe_series_.emplace(std::move(*series));
  }
  return results;
}

Result<void> Results::place_probes(const FluidMesh& mesh,
                                   const std::vector<std::array<double, 3>>& positions) {
  std::vector<ProbeSettings> moved = settings_->probes;
  for (std::size_t i = 0; i < std::min(moved.size(), positions.size()); ++i) moved[i].position = positions[i];
  auto probes = Probes::create(moved, mesh);
  if (!probes) return probes.error();
  probes_ = std::move(*probes);
  return {};
}

io::ResultFiles Results::files(io::PvdCollection& fields) {
  io::ResultFiles files{{&flow_, &forces_}, {&fields}};
  if (probe_series_) files.series.push_back(&*probe_series_);
  return files;
}

Result<void> Results::save_positions(const std::filesystem::path& file, io::PvdCollection& fields) {
  return io::save_positions(file, files(fields));
}

Result<void> Results::restore_positions(const std::filesystem::path& file, io::PvdCollection& fields) {
  return io::restore_positions(file, files(fields));
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

} // namespace drogue::fluid
