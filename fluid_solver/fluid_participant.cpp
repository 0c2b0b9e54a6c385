// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/fluid_participant.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/log.hpp"
#include "common/la_krylov/session.hpp"

namespace drogue::fluid {
namespace {

using v1::FieldContract;

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

std::vector<double> rows(std::span<const double> values, std::span<const std::int32_t> nodes) {
  std::vector<double> out;
  for (const std::int32_t node : nodes)
    out.insert(out.end(), values.begin() + 3 * node, values.begin() + 3 * node + 3);
  return out;
}

participant::FloatArray array(std::vector<double> values, std::uint64_t components) {
  return {{values.size() / components, components}, std::move(values)};
}

} // namespace

Result<void> FluidParticipant::order(Order::Kind kind, std::vector<double> numbers, std::string text) {
  Order order{kind, std::move(numbers), std::move(text)};
  broadcast(order);
  return flow_.execute(order);
}

participant::Description FluidParticipant::describe() {
  participant::Description d;
  d.software = "fluid_solver 0.1.0";
  d.can_rollback = d.can_checkpoint = d.variable_step = d.can_replace_mesh = true;
  using participant::field;
  d.inputs = {field("mesh_displacement", FieldContract::DISPLACEMENT, FieldContract::MESH_NODES, 3),
              field("velocity", FieldContract::VELOCITY, FieldContract::INTERFACE_NODES, 3),
              field("velocity_start", FieldContract::VELOCITY, FieldContract::INTERFACE_NODES, 3,
                    FieldContract::END_OF_STEP, true)};
  if (input_.settings.interface_load == InterfaceLoad::pressure)
    d.outputs = {field("pressure", FieldContract::PRESSURE, FieldContract::INTERFACE_NODES, 1)};
  else
    d.outputs = {field("traction", FieldContract::TRACTION, FieldContract::INTERFACE_NODES, 3),
                 field("mean_traction", FieldContract::TRACTION, FieldContract::INTERFACE_NODES, 3,
                       FieldContract::MEAN_OF_STEP, true)};
  d.outputs.push_back(field("mean_pressure", FieldContract::PRESSURE, FieldContract::INTERFACE_NODES, 1,
                            FieldContract::MEAN_OF_STEP, true));
  d.pids = pids_;
  return d;
}

Result<void> FluidParticipant::configure(const participant::RunInfo& run) {
  return order(Order::Kind::configure, {run.resume ? 1.0 : 0.0}, run.directory.string());
}

Result<participant::InterfaceMesh> FluidParticipant::initialize() {
  DROGUE_TRY(order(Order::Kind::initialize));
  const FluidMesh& mesh = input_.mesh;
  const std::vector<std::int32_t>& nodes = flow_.interface_file_nodes();
  participant::InterfaceMesh m;
  m.points = rows(flow_.initial_points(), nodes);
  m.reference = m.points;
  if (const auto found = mesh.file.node_fields.find("material");
      found != mesh.file.node_fields.end() && found->second.components == 3) {
    m.material = rows(found->second.values, nodes);
    if (std::any_of(m.material.begin(), m.material.end(), [](double v) { return !std::isfinite(v); }))
      m.material.clear();
  }
  const auto boundaries = boundary_indices(mesh, input_.settings.interface);
  for (const BoundaryFace& face : mesh.faces) {
    if (std::find(boundaries.begin(), boundaries.end(), face.boundary) == boundaries.end()) continue;
    for (const std::int32_t node : face.nodes())
      (mesh.dimension == 2 ? m.lines : m.triangles)
          .push_back(std::lower_bound(nodes.begin(), nodes.end(), mesh.to_file[at(node)]) - nodes.begin());
  }
  m.mesh_nodes.assign(nodes.begin(), nodes.end());
  m.mesh_node_count = at(mesh.node_count());
  m.mesh_hash = mesh.hash;
  return m;
}

Result<void> FluidParticipant::begin_step(const participant::StepInfo& step) {
  return order(Order::Kind::begin_step, {step.time, step.time_step, static_cast<double>(step.step)});
}

Result<participant::IterationReport> FluidParticipant::iterate(const participant::Fields& inputs,
                                                               participant::Fields& outputs) {
  participant::report_progress("solving");
  const auto start = inputs.find("velocity_start");
  std::vector<double> numbers{start != inputs.end() ? 1.0 : 0.0};
  for (const char* name : {"mesh_displacement", "velocity"}) {
    const std::vector<double>& values = inputs.at(name).values;
    numbers.insert(numbers.end(), values.begin(), values.end());
  }
  if (start != inputs.end())
    numbers.insert(numbers.end(), start->second.values.begin(), start->second.values.end());
  DROGUE_TRY(order(Order::Kind::iterate, std::move(numbers)));
  const bool pressure = input_.settings.interface_load == InterfaceLoad::pressure;
  auto load = flow_.load();
  if (!load) return load.error();
  outputs[pressure ? "pressure" : "traction"] = array(std::move(*load), pressure ? 1 : 3);
  if (!pressure) {
    auto mean = flow_.mean_traction();
    if (!mean) return mean.error();
    outputs["mean_traction"] = array(std::move(*mean), 3);
  }
  outputs["mean_pressure"] = array(flow_.mean_pressure(), 1);
  const NewtonReport& report = flow_.last_report();
  return participant::IterationReport{static_cast<std::uint32_t>(report.iterations), report.residual,
                                      report.converged, true}; // newton.iterations_per_coupling
}

Result<void> FluidParticipant::commit(bool write_output) {
  return order(Order::Kind::commit, {write_output ? 1.0 : 0.0});
}
Result<void> FluidParticipant::rollback() {
  return order(Order::Kind::rollback);
}
Result<participant::ReplacedMesh> FluidParticipant::replace_mesh(const participant::NewMesh& mesh,
                                                                 bool restoring) {
  participant::report_progress("changing the mesh");
  DROGUE_TRY(
      order(Order::Kind::replace_mesh, {restoring ? 1.0 : 0.0}, mesh.mesh_hash + "\n" + mesh.file.string()));
  const std::vector<std::int32_t>& nodes = flow_.interface_file_nodes();
  const TransferDefects& defects = flow_.last_defects();
  return participant::ReplacedMesh{{nodes.begin(), nodes.end()},
                                   at(input_.mesh.node_count()),
                                   input_.mesh.hash,
                                   defects.mass,
                                   defects.momentum,
                                   defects.energy};
}

Result<void> FluidParticipant::checkpoint(const std::filesystem::path& directory) {
  return order(Order::Kind::checkpoint, {}, directory.string());
}
Result<void> FluidParticipant::restore(const std::filesystem::path& directory) {
  return order(Order::Kind::restore, {}, directory.string());
}

Result<void> serve_flow(Case& input, const std::string& endpoint) {
  CoupledFlow flow(input);
  auto pids = la::process_ids();
  Order order;
  if (la::rank() == 0) {
    for (const std::string& field : input.settings.alone_only)
      spdlog::warn("{}: {} is not used in a coupled run: the coupler sets folder and steps",
                   input.settings.source.where(field), field);
    FluidParticipant solver(input, flow, std::move(pids));
    auto served = participant::serve(solver, participant::serve_options_from_environment(endpoint));
    broadcast(order); // stop
    auto closed = flow.execute(order);
    return served ? closed : served;
  }
  do {
    broadcast(order);
    const auto done = flow.execute(order);
    if (order.kind == Order::Kind::stop) return done;
  } while (true); // errors are the same on every rank; rank 0 decides
}

} // namespace drogue::fluid
