// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/mesh_participant.hpp"

#include <algorithm>

#include "common/base/log.hpp"

namespace drogue::mesh_mover {
namespace {

constexpr const char* state_file = "mesh_mover.state";
constexpr const char* positions_file = "results.state";
constexpr const char* state_kind = "mesh_mover";

/// Coordinates of some nodes of `values` {n, 3}.
std::vector<double> pick(std::span<const double> values, std::span<const std::int32_t> nodes) {
  std::vector<double> picked;
  picked.reserve(3 * nodes.size());
  for (const std::int32_t node : nodes)
    for (std::size_t c = 0; c < 3; ++c) picked.push_back(values[3 * static_cast<std::size_t>(node) + c]);
  return picked;
}

} // namespace

MeshParticipant::MeshParticipant(Case input, std::vector<std::int64_t> pids,
                                 std::filesystem::path remesh_program)
    : settings_(std::move(input.settings)),
      pids_(std::move(pids)),
      initial_mesh_(std::move(input.mesh)),
      remesher_(settings_, std::move(remesh_program)) {}

participant::Description MeshParticipant::describe() {
  using v1::FieldContract;
  participant::Description description;
  description.software = "mesh_mover 0.1.0";
  description.can_rollback = true;
  description.can_checkpoint = true;
  description.variable_step = true;
  description.pids = pids_;
  description.can_replace_mesh = true;
  description.inputs = {
      participant::field("displacement", FieldContract::DISPLACEMENT, FieldContract::INTERFACE_NODES, 3),
      participant::field("translation", FieldContract::TRANSLATION, FieldContract::GLOBAL, 3)};
  description.outputs = {
      participant::field("mesh_displacement", FieldContract::DISPLACEMENT, FieldContract::MESH_NODES, 3),
      participant::field("quality", FieldContract::QUALITY, FieldContract::GLOBAL, 3)};
  return description;
}

Result<void> MeshParticipant::configure(const participant::RunInfo& run) {
  settings_.output.directory = run.directory;
  time_n_ = run.start_time;
  resume_ = run.resume;
  return {};
}

Result<participant::InterfaceMesh> MeshParticipant::initialize() {
  participant::report_progress("reading");
  auto results = Results::create(settings_.output, resume_ ? io::Existing::keep : io::Existing::replace);
  if (!results) return results.error();
  results_ = std::move(*results);
  auto mover = MeshMover::create(std::move(initial_mesh_), settings_);
  if (!mover) return mover.error();
  mover_ = std::move(*mover);
  mesh_hash_ = mesh::hash(mover_->mesh());
  spdlog::info("{} nodes, {} {}, {} interface nodes", mover_->mesh().node_count(), mover_->cells().count(),
               mover_->cells().plural(), mover_->motion().interface_nodes().size());
  if (resume_) return interface_mesh();
  SolveReport start;
  start.quality = mover_->current_quality();
  DROGUE_TRY(results_.write(*mover_, 0, time_n_, start, false));
  return interface_mesh();
}

participant::InterfaceMesh MeshParticipant::interface_mesh() const {
  const mesh::Mesh& mesh = mover_->mesh();
  const auto& nodes = mover_->motion().interface_nodes();
  participant::InterfaceMesh interface;
  interface.points = pick(mesh.points, nodes);
  const auto material = mesh.node_fields.find("material");
  if (material != mesh.node_fields.end() && material->second.components == 3) {
    auto values = pick(material->second.values, nodes);
    const auto is_number = [](double value) { return std::isfinite(value); };
    if (std::all_of(values.begin(), values.end(), is_number)) interface.material = std::move(values);
  }
  const auto local = [&](std::int32_t node) {
    return static_cast<std::int64_t>(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin());
  };
  for (const auto& block : mesh.blocks) {
    const auto is_this = [&](const Boundary& b) { return b.is_interface && b.name == block.group; };
    if (std::none_of(settings_.boundaries.begin(), settings_.boundaries.end(), is_this)) continue;
    if (mover_->cells().dimension == 3 && block.kind == mesh::ElementKind::tri3)
      std::transform(block.nodes.begin(), block.nodes.end(), std::back_inserter(interface.triangles), local);
    if (mover_->cells().dimension == 2 && block.kind == mesh::ElementKind::line2)
      for (const std::int32_t node : with_cells_on_the_left(block.nodes, mover_->cells()))
        interface.lines.push_back(local(node));
  }
  interface.mesh_nodes.assign(nodes.begin(), nodes.end());
  interface.mesh_node_count = static_cast<std::uint64_t>(mesh.node_count());
  interface.mesh_hash = mesh_hash_;
  return interface;
}

Result<void> MeshParticipant::begin_step(const participant::StepInfo& step) {
  participant::report_progress("assembling");
  step_ = step;
  time_n_ = step.time;
  return mover_->begin_step(step.time_step);
}

Result<participant::IterationReport> MeshParticipant::iterate(const participant::Fields& inputs,
                                                              participant::Fields& outputs) {
  participant::report_progress("solving");
  BoundaryInput input;
  input.time = step_.time + step_.time_step;
  input.interface_displacement = inputs.at("displacement").values;
  std::copy_n(inputs.at("translation").values.begin(), 3, input.translation.begin());
  auto report = mover_->solve(input);
  if (!report) return report.error();
  last_ = *report;
  const auto n = static_cast<std::uint64_t>(mover_->mesh().node_count());
  const auto u = mover_->displacement();
  const Quality& q = last_.quality;
  outputs["mesh_displacement"] = {{n, 3}, {u.begin(), u.end()}};
  outputs["quality"] = {{1, 3}, {q.min_volume_ratio, q.worst_mean_ratio, q.mean_mean_ratio}};
  return participant::IterationReport{static_cast<std::uint32_t>(last_.iterations), last_.residual, true};
}

Result<void> MeshParticipant::commit(bool write_output) {
  mover_->commit();
  time_n_ = step_.time + step_.time_step;
  steps_done_ = step_.step;
  replacement_.reset();
  if (!write_output) return {}; // within a step
  replacement_ = remesher_.after_step(*mover_, last_.quality, steps_done_, settings_.output.directory);
  return results_.write(*mover_, steps_done_, time_n_, last_, false);
}

Result<void> MeshParticipant::rollback() {
  mover_->rollback();
  return {};
}

std::optional<participant::NewMesh> MeshParticipant::new_mesh() {
  if (!replacement_) return std::nullopt;
  return participant::NewMesh{replacement_->file, replacement_->mesh_hash, replacement_->reason};
}

Result<participant::ReplacedMesh> MeshParticipant::replace_mesh(const participant::NewMesh& mesh, bool) {
  participant::report_progress("reading");
  mover_.reset(); // one at a time: all ranks share its work
  auto mover = mover_on(mesh.file, mesh.mesh_hash, settings_);
  if (!mover) return mover.error();
  mover_ = std::move(*mover);
  mesh_hash_ = mesh.mesh_hash;
  replacement_.reset();
  participant::ReplacedMesh replaced;
  const auto& nodes = mover_->motion().interface_nodes();
  replaced.mesh_nodes.assign(nodes.begin(), nodes.end());
  replaced.mesh_node_count = static_cast<std::uint64_t>(mover_->mesh().node_count());
  replaced.mesh_hash = mesh_hash_;
  return replaced;
}

Result<void> MeshParticipant::checkpoint(const std::filesystem::path& directory) {
  io::State state;
  state.kind = state_kind;
  state.mesh_hash = mesh_hash_;
  state.time = time_n_;
  state.step = steps_done_;
  mover_->save(state);
  remesher_.save(state);
  DROGUE_TRY(io::write_state(directory / state_file, state));
  return results_.save_positions(directory / positions_file);
}

Result<void> MeshParticipant::restore(const std::filesystem::path& directory) {
  const auto file = directory / state_file;
  const auto state = io::read_state(file);
  if (!state) return state.error();
  if (state->kind != state_kind || state->mesh_hash != mesh_hash_)
    return config_error("{} is a state of \"{}\" on the mesh {}; needed is one of \"{}\" on the mesh {}",
                        file.string(), state->kind, state->mesh_hash, state_kind, mesh_hash_);
  DROGUE_TRY(mover_->load(*state));
  remesher_.load(*state);
  time_n_ = state->time;
  steps_done_ = state->step;
  return resume_ ? results_.restore_positions(directory / positions_file) : Result<void>();
}

} // namespace drogue::mesh_mover
