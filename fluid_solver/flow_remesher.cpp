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

meshing::QualitySummary quality_of(const FluidMesh& mesh, const std::vector<double>& x) {
  std::vector<meshing::Point> points;
  std::vector<meshing::Tet> tets;
  for (std::size_t i = 0; i < x.size(); i += 3) points.emplace_back(x[i], x[i + 1], x[i + 2]);
  for (std::int32_t e = 0; e < mesh.cell_count(); ++e)
    std::copy_n(mesh.cell(e).begin(), 4, tets.emplace_back().begin());
  return meshing::summarise_quality(points, tets);
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
  const meshing::QualitySummary q = quality_of(input_.mesh, x);
  const auto [mean_ratio, angle] = limits();
  if (q.smallest_mean_ratio < mean_ratio)
    return fmt::format("the worst mean ratio is {:.3g} (limit {:.3g})", q.smallest_mean_ratio, mean_ratio);
  if (q.smallest_angle < angle)
    return fmt::format("the smallest angle is {:.3g} degrees (limit {:.3g})", q.smallest_angle, angle);
  return {};
}

RemeshSettings FlowRemesher::limits() const {
  return {std::min(input_.settings.remesh->mean_ratio, worn_.mean_ratio),
          std::min(input_.settings.remesh->angle, worn_.angle)};
}

/// 1 at the nodes of elements near or beyond a limit.
mesh::NodeField FlowRemesher::worn(const mesh::Mesh& file) const {
  const meshing::TetMesh m = meshing::from_mesh(file);
  const RemeshSettings l = limits();
  mesh::NodeField field{1, std::vector<double>(m.points.size(), 0.0)};
  for (meshing::Tet tet : m.tets) {
    if (meshing::volume(m.points, tet) < 0) std::swap(tet[0], tet[1]);
    if (meshing::mean_ratio(m.points, tet) * margin < l.mean_ratio ||
        meshing::smallest_dihedral_angle(m.points, tet) * margin < l.angle)
      for (const std::int32_t node : tet) field.values[static_cast<std::size_t>(node)] = 1;
  }
  return field;
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
  old.node_fields[meshing::worn_field_name] = worn(old);
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
  const meshing::QualitySummary q = quality_of(input_.mesh, input_.mesh.points);
  worn_ = {wear * q.smallest_mean_ratio, wear * q.smallest_angle};
  if (la::rank() == 0)
    spdlog::info(
        "step {}: {}: new mesh {}, {} nodes in place of {}, worst mean ratio {:.3g}, smallest angle {:.3g} "
        "degrees; carried over with a change of {:.2e} of the flux, {:.2e} of the momentum, {:.2e} of the "
        "energy",
        step, reason, file.string(), input_.mesh.node_count(), nodes_before, q.smallest_mean_ratio,
        q.smallest_angle, defects->mass, defects->momentum, defects->energy);
  return true;
}

} // namespace drogue::fluid
