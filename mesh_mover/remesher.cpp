// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/remesher.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "common/base/log.hpp"
#include "common/mesh/msh.hpp"
#include "common/meshing/remesh.hpp"

namespace drogue::mesh_mover {
namespace {

/// Steps without another attempt after one that failed.
constexpr std::uint64_t patience = 10;
/// A new mesh is replaced again when its worst element has become this much worse, even if it never kept the
/// limit.
constexpr double wear = 0.5;

/// Elements this near to a limit, as a part of it, are replaced with those beyond.
constexpr double margin = 0.8;

} // namespace

/// 1 at the nodes of elements near or beyond a limit.
mesh::NodeField Remesher::worn(const MeshMover& mover) const {
  const Limits l = limits(mover);
  const Cells& cells = mover.cells();
  mesh::NodeField field{1, std::vector<double>(mover.points().size() / 3, 0.0)};
  const auto far = [](double ratio) { return std::abs(std::log2(std::max(ratio, 1e-300))); };
  for (std::size_t e = 0; e < cells.count(); ++e) {
    const CellShape s = cell_shape(cells.dimension, mover.points(), cells.cell(e));
    const double angle = std::acos(std::clamp(s.cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
    if (s.mean_ratio * margin < l.mean_ratio || angle * margin < l.angle ||
        far(s.jacobian / mover.initial_shapes().jacobians[e]) > margin * l.f_A ||
        far(s.aspect / std::sqrt(mover.initial_shapes().squared_aspects[e])) > margin * l.f_AR)
      for (const std::int32_t node : cells.cell(e)) field.values[static_cast<std::size_t>(node)] = 1;
  }
  return field;
}

Limits Remesher::limits(const MeshMover& mover) const {
  Limits limits = *settings_.remesh;
  if (!mover.is_replacement()) return limits;
  const Quality fresh = assess(mover.mesh().points, mover.cells(), mover.initial_shapes());
  limits.mean_ratio = std::min(limits.mean_ratio, wear * fresh.worst_mean_ratio);
  limits.angle = std::min(limits.angle, wear * fresh.smallest_angle);
  return limits;
}

Result<mesh::Mesh> Remesher::make(const MeshMover& mover, const std::filesystem::path& file) const {
  mesh::Mesh old = mover.mesh();
  if (old.node_fields.count(meshing::size_field_name) == 0)
    old.node_fields[meshing::size_field_name] = meshing::sizes_of(old, old.points);
  const std::vector<double> u = mover.displacement_since_start();
  old.node_fields[start_displacement_name] = {3, u};
  old.node_fields[meshing::worn_field_name] = worn(mover);
  old.points.assign(mover.points().begin(), mover.points().end());
  if (!program_.empty()) return meshing::remesh_in_process(program_, old, file);
  auto made = meshing::remesh(old);
  if (made) DROGUE_TRY(mesh::write_msh(file, *made));
  return made;
}

std::optional<Replacement> Remesher::after_step(const MeshMover& mover, const Quality& quality,
                                                std::uint64_t step, const std::filesystem::path& directory) {
  if (!settings_.remesh || step < not_before_) return std::nullopt;
  const std::string reason = broken_limit(quality, limits(mover), mover.cells(), mover.points());
  if (reason.empty()) return std::nullopt;
  const auto start = std::chrono::steady_clock::now();
  const auto file = directory / fmt::format("remesh_{:06}.msh", step);
  const auto made = make(mover, file);
  const auto keep = [&](const std::string& why) {
    spdlog::warn("step {}: {}. The mesh should be replaced, but {}; it stays for {} steps", step, reason, why,
                 patience);
    not_before_ = step + patience;
    return std::nullopt;
  };
  if (!made) return keep(made.error().message);
  const Cells cells = cells_of(*made);
  const auto shapes = initial_shapes(made->points, cells);
  if (!shapes) return keep(shapes.error().message);
  const Quality fresh = assess(made->points, cells, *shapes);
  if (!broken_limit(fresh, *settings_.remesh, cells, made->points).empty() &&
      fresh.worst_mean_ratio <= quality.worst_mean_ratio)
    return keep(fmt::format("a new one has the worst mean ratio {:.3g} in place of {:.3g}",
                            fresh.worst_mean_ratio, quality.worst_mean_ratio));
  spdlog::info(
      "step {}: new mesh {} ({:.1f} s): {} nodes in place of {}, worst mean ratio {:.3g} in place of {:.3g}, "
      "smallest angle {:.3g} degrees in place of {:.3g}",
      step, file.string(), std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
      made->node_count(), mover.mesh().node_count(), fresh.worst_mean_ratio, quality.worst_mean_ratio,
      fresh.smallest_angle, quality.smallest_angle);
  return Replacement{std::filesystem::absolute(file), mesh::hash(*made), reason};
}

void Remesher::save(io::State& state) const {
  state.add("remesh_not_before", {1}, {static_cast<double>(not_before_)});
}

void Remesher::load(const io::State& state) {
  const auto* array = state.find("remesh_not_before");
  not_before_ = array && array->values.size() == 1 ? static_cast<std::uint64_t>(array->values[0]) : 0;
}

Result<std::unique_ptr<MeshMover>> mover_on(const std::filesystem::path& file, const std::string& mesh_hash,
                                            const Settings& settings) {
  auto mesh = mesh::read_msh(file);
  if (!mesh) return mesh.error();
  if (const std::string found = mesh::hash(*mesh); found != mesh_hash)
    return config_error("{} holds the mesh {} in place of {}", file.string(), found, mesh_hash);
  return MeshMover::create(std::move(*mesh), settings);
}

} // namespace drogue::mesh_mover
