// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/results.hpp"

#include <fmt/format.h>

namespace drogue::structure {
namespace {

/// Sum of m v.
std::array<double, 3> momentum(const Model& model, std::span<const double> v) {
  std::array<double, 3> sum{};
  for (std::size_t i = 0; i < v.size(); ++i) sum[i % 3] += model.mass[i / 3] * v[i];
  return sum;
}

/// Sum of m g.
std::array<double, 3> weight(const Model& model, double time) {
  std::array<double, 3> sum{};
  for (const WeightedLoad& load : model.loads)
    if (load.name == "gravity")
      for (std::size_t k = 0; k < load.nodes.size(); ++k)
        for (std::size_t c = 0; c < 3; ++c) {
          const double* X = &model.mesh.points[3 * static_cast<std::size_t>(load.nodes[k])];
          if (!load.value[c].is_zero()) sum[c] += load.weight[k] * load.value[c](X[0], X[1], X[2], time);
        }
  return sum;
}

} // namespace

Results::Results(const Settings& settings, const Model& model, std::filesystem::path directory)
    : settings_(settings.output), model_(model), directory_(std::move(directory)) {
  for (const ProbeSettings& probe : settings.probes) probes_.push_back(locate(model, probe));
  config::Report reported_by_the_check;
  line_forces_ = line_forces(settings, model, reported_by_the_check);
}

std::vector<std::string> Results::series_columns() const {
  std::vector<std::string> columns = {
      "time",          "step",           "newton_iterations",   "kinetic_energy",
      "strain_energy", "unbalance",      "max_stress",          "min_stress",
      "max_tension",   "slack_fraction", "wrinkled_fraction",   "external_work",
      "support_work",  "actuator_work",  "damping_dissipation", "energy_lost"};
  const auto add = [&](const std::string& name) {
    for (const char* c : {"x", "y", "z"}) columns.push_back(fmt::format("{}_{}", name, c));
  };
  add("momentum");
  add("weight");
  add("external_force");
  add("interface_force");
  for (const SupportSet& support : model_.supports) add("reaction_" + support.group);
  for (const LineForce& force : line_forces_) add("line_force_" + force.name);
  return columns;
}

Result<void> Results::open(std::uint64_t first_step, io::Existing existing) {
  const std::string suffix = first_step > 1 ? fmt::format("_from_{}", first_step) : "";
  auto series =
      io::CsvWriter::create(directory_ / ("structure" + suffix + ".csv"), series_columns(), existing);
  if (!series) return series.error();
  series_ = std::move(*series);
  if (!probes_.empty()) {
    std::vector<std::string> columns = {"time"};
    for (const ProbePoint& probe : probes_)
      for (const char* quantity : {"", "velocity_", "acceleration_"})
        for (const char* c : {"x", "y", "z"})
          columns.push_back(fmt::format("{}_{}{}", probe.name, quantity, c));
    auto probes = io::CsvWriter::create(directory_ / ("probes" + suffix + ".csv"), columns, existing);
    if (!probes) return probes.error();
    probe_series_ = std::move(*probes);
  }
  collection_ = io::PvdCollection(directory_ / ("structure" + suffix + ".pvd"));
  open_ = true;
  return {};
}

io::ResultFiles Results::files() {
  io::ResultFiles files{{&series_}, {&collection_}};
  if (probe_series_) files.series.push_back(&*probe_series_);
  return files;
}

Result<void> Results::save_positions(const std::filesystem::path& file) {
  return open_ ? io::save_positions(file, files()) : Result<void>();
}

Result<void> Results::continue_from(const std::filesystem::path& file, std::uint64_t first_step) {
  if (!std::filesystem::exists(file)) return {}; // a checkpoint before the first step
  DROGUE_TRY(open(first_step, io::Existing::keep));
  return io::restore_positions(file, files());
}

Result<void> Results::step(const Step& step) {
  const std::uint64_t k = step.state.step;
  if (!open_) DROGUE_TRY(open(k));
  if (k % static_cast<std::uint64_t>(settings_.series_interval) == 0) DROGUE_TRY(row(step));
  if (!step.may_write_fields || settings_.field_interval == 0) return {};
  return k % static_cast<std::uint64_t>(settings_.field_interval) == 0 ? fields(step.state) : Result<void>();
}

Result<void> Results::row(const Step& step) {
  const State& state = step.state;
  const Balance& balance = step.balance;
  const StressFields stress = stress_fields(model_, state.u, state.time);
  std::vector<double> values = {state.time,
                                static_cast<double>(state.step),
                                static_cast<double>(step.newton_iterations),
                                balance.kinetic_energy,
                                balance.strain_energy,
                                balance.unbalance,
                                stress.max_stress,
                                stress.min_stress,
                                stress.max_tension,
                                stress.slack_fraction,
                                stress.wrinkled_fraction,
                                balance.ledger.external,
                                balance.ledger.support,
                                balance.ledger.actuator,
                                balance.ledger.damping,
                                balance.energy_lost};
  const auto add = [&](const std::array<double, 3>& value) {
    values.insert(values.end(), value.begin(), value.end());
  };
  add(momentum(model_, state.v));
  add(weight(model_, state.time));
  add(balance.external_force);
  add(balance.interface_force);
  for (const auto& reaction : balance.reactions) add(reaction);
  for (const LineForce& force : line_forces_) add(force(model_, stress, state.u));
  DROGUE_TRY(series_.row(values));
  if (!probe_series_) return {};
  values = {state.time};
  for (const ProbePoint& probe : probes_)
    for (const std::vector<double>* field : {&state.u, &state.v, &state.a}) {
      const auto value = probe(*field);
      values.insert(values.end(), value.begin(), value.end());
    }
  return probe_series_->row(values);
}

Result<void> Results::fields(const State& state) {
  if (settings_.field_interval == 0 || last_fields_ == state.step) return {};
  if (!open_) DROGUE_TRY(open(state.step));
  const StressFields stress = stress_fields(model_, state.u, state.time);
  std::vector<double> points = model_.mesh.points;
  for (std::size_t i = 0; i < points.size(); ++i) points[i] += state.u[i];
  io::VtuData data;
  data.points = points;
  for (const AnyBatch& any : model_.batches)
    std::visit([&](const auto& batch) { data.blocks.push_back(&model_.mesh.blocks[batch.block]); }, any);
  data.point_data = {{"displacement", 3, state.u},
                     {"velocity", 3, state.v},
                     {"acceleration", 3, state.a},
                     {"principal_stress_1", 1, stress.nodal_largest},
                     {"principal_stress_2", 1, stress.nodal_smallest}};
  data.cell_data = {{"principal_stress_1", 1, stress.cell_largest},
                    {"principal_stress_2", 1, stress.cell_smallest},
                    {"principal_direction_1", 3, stress.cell_largest_direction},
                    {"principal_direction_2", 3, stress.cell_smallest_direction},
                    {"tension", 1, stress.cell_tension},
                    {"wrinkle_state", 1, stress.cell_wrinkle_state}};
  const auto file = directory_ / fmt::format("structure_{:06}.vtu", state.step);
  DROGUE_TRY(io::write_vtu(file, data));
  last_fields_ = state.step;
  return collection_.add(state.time, file);
}

} // namespace drogue::structure
