// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/scheme/exchange.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <spdlog/spdlog.h>

namespace drogue::coupler {
namespace {

using participant::Fields;
using participant::FloatArray;

/// {participant::element_arrays}
constexpr std::array kinds{mesh::ElementKind::line2, mesh::ElementKind::line3, mesh::ElementKind::tri3,
                           mesh::ElementKind::tri6,  mesh::ElementKind::quad4, mesh::ElementKind::quad9};
static_assert(kinds.size() == participant::element_arrays.size());

projection::Surface surface_of(const std::string& name, const participant::InterfaceMesh& mesh) {
  projection::Surface s{name, mesh.points, mesh.reference, mesh.material, {}};
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const auto& nodes = mesh.*participant::element_arrays[i].elements;
    if (!nodes.empty()) s.blocks.push_back({name, kinds[i], {nodes.begin(), nodes.end()}});
  }
  return s;
}

FloatArray field(std::vector<double> values) {
  const std::uint64_t n = values.size() / 3;
  return {{n, 3}, std::move(values)};
}
FloatArray field(std::span<const double> values) {
  return field(std::vector<double>(values.begin(), values.end()));
}

Vector3 to_array(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

void say(const projection::MatchReport& r) {
  spdlog::info(
      "surfaces paired: {} points, largest gap {:.2e} of the size, worst normal angle {:.1f} degrees, "
      "{:.2f} % of the structure dry, fluid on {} side{}{}",
      r.points, r.largest_gap, r.worst_normal_angle, 100 * r.dry_area, r.fluid_sides,
      r.fluid_sides == 1 ? "" : "s", r.matching ? ", the meshes match: fields are copied" : "");
}

} // namespace

Result<Exchange> Exchange::create(Participants& participants, const CaseSettings& settings) {
  projection::Settings pairing = settings.projection;
  pairing.recover_traction = participants.structure_takes_traction();
  auto interface = projection::make_interface(surface_of("structure", participants.structure_interface),
                                              surface_of("fluid", participants.fluid_interface), pairing);
  if (!interface) return interface.error();
  say(interface->report);
  Exchange exchange(participants, std::move(*interface));
  exchange.outer_boundary_follows_ = settings.outer_boundary_follows;
  std::map<std::int64_t, std::int64_t> fluid_node;
  const auto& nodes = participants.fluid_interface.mesh_nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) fluid_node[nodes[i]] = static_cast<std::int64_t>(i);
  for (const std::int64_t node : participants.mesh_interface.mesh_nodes)
    exchange.to_mesh_mover_.push_back(fluid_node.at(node)); // check_same_mesh: the same set of nodes
  exchange.fluid_d_.resize(participants.fluid_interface.points.size());
  exchange.fluid_x_.resize(exchange.fluid_d_.size());
  exchange.fluid_v_.resize(exchange.fluid_d_.size());
  exchange.fluid_v_start_.resize(exchange.fluid_d_.size());
  exchange.structure_x_.resize(exchange.structure_size());
  exchange.force_.resize(exchange.structure_size());
  if (pairing.recover_traction) exchange.traction_.resize(exchange.structure_size());
  return exchange;
}

Vector3 Exchange::mean(std::span<const double> field) const {
  Vector3 m{};
  surface_.mean(field, 3, m);
  return m;
}

Vector3 Exchange::vector_area(std::span<const double> d) const {
  std::vector<double> x = interface_.structure.points;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += d[i];
  return to_array(projection::vector_area(interface_.structure, x));
}

Result<FloatArray> Exchange::move_mesh(const Station& at, std::span<const double> d,
                                       IterationRecord& record) {
  Fields inputs;
  FloatArray& wanted = inputs["displacement"] = FloatArray{{to_mesh_mover_.size(), 3}, {}};
  wanted.values.reserve(3 * to_mesh_mover_.size());
  for (const std::int64_t i : to_mesh_mover_) {
    const auto row = fluid_d_.begin() + 3 * i;
    wanted.values.insert(wanted.values.end(), row, row + 3);
  }
  const Vector3 mean_d = outer_boundary_follows_ ? mean(d) : Vector3{};
  inputs["translation"] = {{1, 3}, {mean_d.begin(), mean_d.end()}};
  auto outputs = participants_.mesh_mover(at, std::move(inputs));
  if (!outputs) return outputs.error();
  if (const auto quality = outputs->find("quality");
      quality != outputs->end() && !quality->second.values.empty())
    record.smallest_volume_ratio = quality->second.values[0];
  return std::move(outputs->at("mesh_displacement"));
}

Result<FloatArray> Exchange::solve_flow(const Station& at, FloatArray mesh_displacement,
                                        std::span<const double> v_start) {
  Fields inputs;
  inputs["mesh_displacement"] = std::move(mesh_displacement);
  if (!v_start.empty()) {
    if (!std::equal(v_start.begin(), v_start.end(), v_start_.begin(), v_start_.end())) {
      v_start_.assign(v_start.begin(), v_start.end()); // it stays for a step, mostly
      DROGUE_TRY(interface_.field.apply(v_start_, fluid_v_start_));
    }
    inputs["velocity_start"] = field(fluid_v_start_);
  }
  inputs["velocity"] = field(fluid_v_);
  auto outputs = participants_.fluid(at, std::move(inputs));
  if (!outputs) return outputs.error();
  return std::move(outputs->at(participants_.load_field()));
}

void Exchange::extrapolate(std::span<const double> last, double weight) {
  last_force_.assign(last.begin(), last.end());
  extrapolation_ = weight;
}

Result<void> Exchange::transfer_load(const FloatArray& load, LoadShare share, std::span<const double> d,
                                     std::span<const double> v, IterationRecord& record) {
  for (std::size_t i = 0; i < fluid_x_.size(); ++i) fluid_x_[i] = interface_.fluid.points[i] + fluid_d_[i];
  for (std::size_t i = 0; i < structure_x_.size(); ++i)
    structure_x_[i] = interface_.structure.points[i] + d[i];
  const projection::FluidSide fluid{fluid_x_, fluid_v_};
  const projection::LoadSums on_fluid = participants_.load_is_pressure()
                                            ? interface_.load.from_pressure(fluid, load.values, force_)
                                            : interface_.load.from_traction(fluid, load.values, force_);
  const projection::LoadSums on_structure = projection::sum_nodal(structure_x_, force_, v);
  record.force_fluid = to_array(on_fluid.force);
  record.force_structure = to_array(on_structure.force);
  const double scale = std::max(on_fluid.force.norm(), 1e-300);
  record.force_defect = (on_fluid.force - on_structure.force).norm() / scale;
  record.moment_fluid = to_array(on_fluid.moment);
  record.moment_structure = to_array(on_structure.moment);
  record.power_fluid = on_fluid.power;
  record.power_structure = on_structure.power;
  const std::array<projection::ProjectedField, 2> projected{{{d, fluid_d_}, {v, fluid_v_}}};
  std::array<double, 2> defects{};
  projection::projection_defects(interface_, projected, defects);
  record.displacement_defect = defects[0];
  record.velocity_defect = defects[1];
  if (first_force_.empty()) first_force_ = force_;
  for (double& f : force_) f *= share.factor;
  given_force_ = force_;
  for (std::size_t i = 0; i < last_force_.size(); ++i)
    force_[i] += extrapolation_ * (given_force_[i] - last_force_[i]);
  for (std::size_t i = 0; i < force_.size(); ++i)
    force_[i] -= share.factor * share.withheld * first_force_[i];
  return {};
}

Result<Fields> Exchange::structure_inputs(std::span<const double> d, std::span<const double> force) {
  Fields inputs{{"force", field(force)}, {"displacement", field(d)}};
  if (traction_.empty()) return inputs;
  DROGUE_TRY(interface_.load.recover_traction(force, traction_));
  inputs["traction"] = field(traction_);
  return inputs;
}

Result<void> Exchange::end_structure(std::vector<double>& d_tilde, std::vector<double>& v_tilde) {
  auto outputs = participants_.end_structure();
  if (!outputs) return outputs.error();
  d_tilde = std::move(outputs->at("displacement").values);
  v_tilde = std::move(outputs->at("velocity").values);
  return {};
}

Result<void> Exchange::structure(const Station& at, std::span<const double> d, std::span<const double> force,
                                 std::vector<double>& d_tilde, std::vector<double>& v_tilde) {
  auto inputs = structure_inputs(d, force);
  if (!inputs) return inputs.error();
  DROGUE_TRY(participants_.begin_structure(at, std::move(*inputs)));
  return end_structure(d_tilde, v_tilde);
}

Result<void> Exchange::fluid(const Station& at, LoadShare share, std::span<const double> d,
                             std::span<const double> v, std::span<const double> v_start,
                             IterationRecord& record) {
  const std::array<projection::FieldProjection::Transfer, 2> both{{{d, fluid_d_}, {v, fluid_v_}}};
  DROGUE_TRY(interface_.field.apply(both));
  auto mesh_displacement = move_mesh(at, d, record);
  if (!mesh_displacement) return mesh_displacement.error();
  const auto load = solve_flow(at, std::move(*mesh_displacement), v_start);
  if (!load) return load.error();
  DROGUE_TRY(transfer_load(*load, share, d, v, record));
  report(record);
  return {};
}

/// The solvers' own iterations in their last solves.
void Exchange::report(IterationRecord& record) const {
  record.fluid_inner_iterations = participants_.fluid_report().inner_iterations();
  record.fluid_inner_residual = participants_.fluid_report().inner_residual();
  record.structure_inner_iterations = participants_.structure_report().inner_iterations();
  record.structure_inner_residual = participants_.structure_report().inner_residual();
}

Result<void> Exchange::evaluate(const Station& at, LoadShare share, std::span<const double> d,
                                std::span<const double> v, std::span<const double> v_start,
                                std::span<const double> given_force, std::vector<double>& d_tilde,
                                std::vector<double>& v_tilde, IterationRecord& record) {
  if (given_force.empty()) {
    DROGUE_TRY(fluid(at, share, d, v, v_start, record));
    DROGUE_TRY(structure(at, d, force_, d_tilde, v_tilde));
  } else {
    auto inputs = structure_inputs(d, given_force);
    if (!inputs) return inputs.error();
    DROGUE_TRY(participants_.begin_structure(at, std::move(*inputs)));
    const auto flow = fluid(at, share, d, v, v_start, record);
    const auto answer = end_structure(d_tilde, v_tilde); // where the fluid failed, too: before a rollback
    if (!flow) return flow.error();
    if (!answer) return answer.error();
  }
  report(record);
  return {};
}

} // namespace drogue::coupler
