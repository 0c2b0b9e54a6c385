// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/flow_remesher.hpp"

#include <algorithm>

#include "common/base/log.hpp"
#include "common/la_krylov/session.hpp"
#include "common/mesh/msh.hpp"
#include "common/meshing/quality.hpp"
#include "common/meshing/remesh.hpp"

namespace drogue::fluid {
namespace {

/// Steps without another attempt after one that failed.
constexpr std::uint64_t patience = 10;
/// A new mesh is replaced again when its worst element has become this much worse, even if it never kept the
/// limit.
constexpr double wear = 0.5;
/// Elements this near to a limit, as a part of it, are replaced with those beyond.
constexpr double margin = 0.8;

std::vector<meshing::Point> points_of(const std::vector<double>& x) {
  std::vector<meshing::Point> points;
  for (std::size_t i = 0; i < x.size(); i += 3) points.emplace_back(x[i], x[i + 1], x[i + 2]);
  return points;
}

/// Mean ratio and smallest angle of a cell.
RemeshSettings shape_of(const std::vector<meshing::Point>& x, std::span<const std::int32_t> cell) {
  if (cell.size() == 3) {
    const meshing::Triangle t{cell[0], cell[1], cell[2]};
    return {meshing::mean_ratio(x, t), meshing::smallest_angle(x, t)};
  }
  const meshing::Tet tet{cell[0], cell[1], cell[2], cell[3]};
  return {meshing::mean_ratio(x, tet), meshing::smallest_dihedral_angle(x, tet)};
}

RemeshSettings worst_shape(const FluidMesh& mesh, const std::vector<double>& x) {
  const std::vector<meshing::Point> points = points_of(x);
  RemeshSettings worst{1, 180};
  for (std::int32_t e = 0; e < mesh.cell_count(); ++e) {
    const RemeshSettings shape = shape_of(points, mesh.cell(e));
    worst = {std::min(worst.mean_ratio, shape.mean_ratio), std::min(worst.angle, shape.angle)};
  }
  return worst;
}

/// Rank 0's text on every rank. @note Collective
void broadcast(std::string& text) {
  std::uint64_t length = text.size();
  la::broadcast_passively(&length, sizeof(length));
  text.resize(length);
  la::broadcast_passively(text.data(), length);
}

} // namespace

std::string FlowRemesher::trouble(const std::vector<double>& x) const {
  const RemeshSettings worst = worst_shape(input_.mesh, x);
  const auto [mean_ratio, angle] = limits();
  if (worst.mean_ratio < mean_ratio)
    return fmt::format("the worst mean ratio is {:.3g} (limit {:.3g})", worst.mean_ratio, mean_ratio);
  if (worst.angle < angle)
    return fmt::format("the smallest angle is {:.3g} degrees (limit {:.3g})", worst.angle, angle);
  return {};
}

RemeshSettings FlowRemesher::limits() const {
  return {std::min(input_.settings.remesh->mean_ratio, worn_.mean_ratio),
          std::min(input_.settings.remesh->angle, worn_.angle)};
}

/// 1 at the nodes, in the file's order, of elements near or beyond a limit; `x` in the solver's.
mesh::NodeField FlowRemesher::worn(const std::vector<double>& x) const {
  const std::vector<meshing::Point> points = points_of(x);
  const RemeshSettings l = limits();
  std::vector<double> nodes(points.size(), 0.0);
  for (std::int32_t e = 0; e < input_.mesh.cell_count(); ++e) {
    const auto cell = input_.mesh.cell(e);
    const RemeshSettings shape = shape_of(points, cell);
    if (shape.mean_ratio * margin < l.mean_ratio || shape.angle * margin < l.angle)
      for (const std::int32_t node : cell) nodes[static_cast<std::size_t>(node)] = 1;
  }
  return {1, input_.mesh.reordered_to_file(nodes, 1)};
}

Result<std::string> FlowRemesher::make(const FlowState& state, std::span<const double> start,
                                       const std::filesystem::path& file) const {
  const FluidMesh& mesh = input_.mesh;
  mesh::Mesh old = mesh.file;
  if (old.node_fields.count(meshing::size_field_name) == 0)
    old.node_fields[meshing::size_field_name] = meshing::sizes_of(old, old.points);
  std::vector<double> u = state.x;
  for (std::size_t i = 0; i < u.size(); ++i) u[i] -= start[i];
  old.node_fields[start_displacement_name] = {3, mesh.reordered_to_file(u, 3)};
  old.points = mesh.reordered_to_file(state.x, 3);
  old.node_fields[meshing::worn_field_name] = worn(state.x);
  if (!program_.empty()) {
    const auto made = meshing::remesh_in_process(program_, old, file);
    return made ? Result<std::string>(mesh::hash(*made)) : made.error();
  }
  const auto made = meshing::remesh(old);
  if (!made) return made.error();
  DROGUE_TRY(mesh::write_msh(file, *made));
  return mesh::hash(*made);
}

Result<bool> FlowRemesher::after_step(FlowRun& run, std::span<const double> start) {
  const FlowState& state = run.solver().state(); // until the mesh is replaced
  const std::uint64_t step = state.step;
  if (!input_.settings.remesh || step < not_before_) return false;
  const std::string reason = trouble(state.x);
  if (reason.empty()) return false;
  const auto file = input_.settings.output.directory / fmt::format("remesh_{:06}.msh", step);
  std::string hash;
  if (la::rank() == 0) {
    const auto made = make(state, start, file);
    if (made)
      hash = *made;
    else
      spdlog::warn("step {}: {}. The mesh should be replaced, but {}; it stays for {} steps", step, reason,
                   made.error().message, patience);
  }
  broadcast(hash);
  if (hash.empty()) {
    not_before_ = step + patience;
    return false;
  }
  const std::int32_t nodes_before = input_.mesh.node_count();
  const auto defects = run.replace_mesh(file, hash, false);
  if (!defects) return defects.error();
  const RemeshSettings fresh = worst_shape(input_.mesh, input_.mesh.points);
  worn_ = {wear * fresh.mean_ratio, wear * fresh.angle};
  if (la::rank() == 0)
    spdlog::info(
        "step {}: {}: new mesh {}, {} nodes in place of {}, worst mean ratio {:.3g}, smallest angle {:.3g} "
        "degrees; carried over with a change of {:.2e} of the flux, {:.2e} of the momentum, {:.2e} of the "
        "energy",
        step, reason, file.string(), input_.mesh.node_count(), nodes_before, fresh.mean_ratio, fresh.angle,
        defects->mass, defects->momentum, defects->energy);
  return true;
}

} // namespace drogue::fluid
