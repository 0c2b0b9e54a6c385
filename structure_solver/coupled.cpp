// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/coupled.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/log.hpp"
#include "structure_solver/state_io.hpp"

namespace drogue::structure {
namespace {

using v1::FieldContract;

constexpr const char* checkpoint_file = "structure.state";
constexpr const char* positions_file = "results.state";
constexpr std::uint64_t first_step = 1; ///< of every coupled run, whatever it started from

/// Values of a {nodes, k} array on some nodes.
std::vector<double> gather(std::span<const double> values, std::span<const std::int32_t> nodes,
                           std::size_t k) {
  std::vector<double> result;
  result.reserve(k * nodes.size());
  for (const std::int32_t node : nodes)
    for (std::size_t c = 0; c < k; ++c) result.push_back(values[k * static_cast<std::size_t>(node) + c]);
  return result;
}

std::vector<std::int64_t>& array_for(mesh::ElementKind kind, participant::InterfaceMesh& out) {
  switch (kind) {
  case mesh::ElementKind::line2:
    return out.lines;
  case mesh::ElementKind::line3:
    return out.lines3;
  case mesh::ElementKind::tri6:
    return out.triangles6;
  case mesh::ElementKind::quad4:
    return out.quadrangles4;
  case mesh::ElementKind::quad9:
    return out.quadrangles9;
  case mesh::ElementKind::tri3:
  case mesh::ElementKind::point1: // build_model: the interface has none of these
  case mesh::ElementKind::tet4:
  case mesh::ElementKind::tet10:
  case mesh::ElementKind::hex27:
    break;
  }
  return out.triangles;
}

void add_elements(const mesh::ElementBlock& block, std::span<const std::int32_t> interface_nodes,
                  participant::InterfaceMesh& out) {
  for (const std::int32_t node : block.nodes)
    array_for(block.kind, out)
        .push_back(std::lower_bound(interface_nodes.begin(), interface_nodes.end(), node) -
                   interface_nodes.begin());
}

std::vector<double> material_coordinates(const mesh::Mesh& mesh, std::span<const std::int32_t> nodes) {
  const auto field = mesh.node_fields.find("material");
  if (field == mesh.node_fields.end() || field->second.components != 3) return {};
  std::vector<double> values = gather(field->second.values, nodes, 3);
  const bool complete = std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  return complete ? std::move(values) : std::vector<double>{};
}

} // namespace

Coupled::Coupled(Case c)
    : case_(std::move(c)), integrator_(*case_.model, case_.integrator_options(), case_.start) {}

participant::Description Coupled::describe() {
  participant::Description d;
  d.software = "structure_solver";
  d.can_rollback = true;
  d.can_checkpoint = true;
  d.variable_step = true;
  d.inputs = {
      participant::field("force", FieldContract::FORCE, FieldContract::INTERFACE_NODES, 3),
      participant::field("displacement", FieldContract::DISPLACEMENT, FieldContract::INTERFACE_NODES, 3)};
  d.outputs = {
      participant::field("displacement", FieldContract::DISPLACEMENT, FieldContract::INTERFACE_NODES, 3),
      participant::field("velocity", FieldContract::VELOCITY, FieldContract::INTERFACE_NODES, 3)};
  return d;
}

Result<void> Coupled::configure(const participant::RunInfo& run) {
  integrator_.set_time(run.start_time);
  if (case_.settings.time.balanced_start) integrator_.balance_start();
  resume_ = run.resume;
  results_.emplace(case_.settings, *case_.model, run.directory);
  return {};
}

Result<participant::InterfaceMesh> Coupled::initialize() {
  const Model& model = *case_.model;
  const mesh::Mesh& mesh = model.mesh;
  nodes_ = mesh.nodes_of(case_.settings.interface);
  u_initial_ = gather(integrator_.committed().u, nodes_, 3);
  force_.assign(model.equation_count(), 0.0);

  participant::InterfaceMesh out;
  out.reference = gather(mesh.points, nodes_, 3);
  out.points = out.reference;
  for (std::size_t i = 0; i < out.points.size(); ++i) out.points[i] += u_initial_[i];
  out.material = material_coordinates(mesh, nodes_);
  out.velocity = gather(integrator_.committed().v, nodes_, 3);
  out.mesh_nodes.assign(nodes_.begin(), nodes_.end());
  out.mesh_node_count = model.node_count();
  out.mesh_hash = model.mesh_hash;
  for (const mesh::ElementBlock* block : mesh.blocks_of(case_.settings.interface))
    add_elements(*block, nodes_, out);
  return out;
}

Result<void> Coupled::begin_step(const participant::StepInfo& step) {
  integrator_.set_time(step.time);
  integrator_.set_step(step.step - 1);
  integrator_.begin_step(step.time_step, Integrator::Predictor::extrapolate);
  step_iterations_ = 0;
  return {};
}

void Coupled::start_iterate(const participant::Fields& inputs) {
  const auto& force = inputs.at("force").values;
  for (std::size_t k = 0; k < nodes_.size(); ++k)
    std::copy_n(&force[3 * k], 3, &force_[3 * static_cast<std::size_t>(nodes_[k])]);
  target_ = inputs.at("displacement").values;
  for (std::size_t i = 0; i < target_.size(); ++i) target_[i] += u_initial_[i];
  integrator_.set_interface_force(force_);
  integrator_.set_displacement(nodes_, target_);
}

participant::FloatArray Coupled::on_interface(std::span<const double> values) const {
  return {{nodes_.size(), 3}, gather(values, nodes_, 3)};
}

Result<participant::IterationReport> Coupled::iterate(const participant::Fields& inputs,
                                                      participant::Fields& outputs) {
  start_iterate(inputs);
  participant::report_progress("structure: Newton");
  const int count = case_.settings.newton.iterations_per_coupling;
  const auto outcome = count > 0 ? integrator_.iterate(count) : integrator_.iterate_to_tolerance();
  if (!outcome) return outcome.error();
  step_iterations_ += outcome->iterations;
  if (count == 0 && !outcome->converged)
    return retryable_error(
        "the structure's Newton iteration did not converge in {} iterations: correction {:.3g}, residual "
        "{:.3g} of the step's first{}",
        outcome->iterations, outcome->correction, outcome->residual, integrator_.worst_nodes());
  participant::FloatArray u = on_interface(integrator_.trial().u);
  for (std::size_t i = 0; i < u.values.size(); ++i) u.values[i] -= u_initial_[i];
  outputs["displacement"] = std::move(u);
  outputs["velocity"] = on_interface(integrator_.trial().v);
  return participant::IterationReport{static_cast<std::uint32_t>(outcome->iterations), outcome->residual,
                                      outcome->converged, count > 0};
}

Result<void> Coupled::commit(bool write_output) {
  integrator_.commit();
  before_parts_.reset();
  advanced_ = true;
  return results_->step({integrator_.committed(), integrator_.balance(), step_iterations_, write_output});
}

Result<void> Coupled::end_part() {
  if (!before_parts_) before_parts_ = integrator_.committed();
  integrator_.commit();
  return {};
}

Result<void> Coupled::undo_parts() {
  if (before_parts_) integrator_.reset(std::move(*before_parts_));
  before_parts_.reset();
  return {};
}

Result<void> Coupled::finish() {
  if (!advanced_) return {};
  return results_->fields(integrator_.committed());
}

Result<void> Coupled::rollback() {
  integrator_.rollback();
  return {};
}

Result<void> Coupled::checkpoint(const std::filesystem::path& directory) {
  DROGUE_TRY(save_state(directory / checkpoint_file, *case_.model, integrator_.committed()));
  return results_->save_positions(directory / positions_file);
}

Result<void> Coupled::restore(const std::filesystem::path& directory) {
  auto state = read_state(directory / checkpoint_file, *case_.model);
  if (!state) return state.error();
  integrator_.reset(std::move(*state));
  DROGUE_TRY(resume_ ? results_->continue_from(directory / positions_file, first_step)
                     : results_->open(first_step));
  advanced_ = true;
  return {};
}

} // namespace drogue::structure
