// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/field_files.hpp"

#include <fmt/format.h>

#include "common/la_krylov/node_graph.hpp"
#include "common/la_krylov/session.hpp"
#include "fluid_solver/flow_fields.hpp"

namespace drogue::fluid {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

} // namespace

FieldFiles::FieldFiles(const Settings& settings, const FluidMesh& mesh,
                       const std::filesystem::path& directory)
    : settings_(&settings), mesh_(&mesh), directory_(directory), collection_(directory / "fluid.pvd") {
  choose_cells();
}

void FieldFiles::take_mesh() {
  nodes_.clear();
  blocks_.clear();
  choose_cells();
}

void FieldFiles::choose_cells() {
  const la::RowRange own = la::partition_rows(mesh_->graph, la::rank_count())[at(la::rank())];
  std::vector<std::int32_t> number(at(mesh_->node_count()), -1); // of a node of the file in the piece
  for (const mesh::ElementBlock& block : mesh_->file.blocks) {
    if (mesh::dimension(block.kind) != mesh_->dimension) continue;
    mesh::ElementBlock& piece = blocks_.emplace_back();
    piece.kind = block.kind;
    for (std::int32_t e = 0; e < block.count(); ++e) {
      const auto element = block.element(e);
      if (!own.has(mesh_->from_file[at(element[0])])) continue;
      piece.nodes.insert(piece.nodes.end(), element.begin(), element.end());
      for (const std::int32_t node : element) number[at(node)] = 0;
    }
  }
  for (std::int32_t node = 0; node < mesh_->node_count(); ++node)
    if (number[at(node)] == 0) {
      number[at(node)] = static_cast<std::int32_t>(nodes_.size());
      nodes_.push_back(node);
    }
  for (mesh::ElementBlock& block : blocks_)
    for (std::int32_t& node : block.nodes) node = number[at(node)];
}

std::vector<double> FieldFiles::values_of(std::span<const double> nodal, int components,
                                          double factor) const {
  const std::size_t width = at(components);
  std::vector<double> out;
  out.reserve(nodes_.size() * width);
  for (const std::int32_t node : nodes_)
    for (std::size_t d = 0; d < width; ++d)
      out.push_back(factor * nodal[at(mesh_->from_file[at(node)]) * width + d]);
  return out;
}

Result<void> FieldFiles::write(const FlowState& state, const FieldAverages& averages, bool force) {
  const auto interval = static_cast<std::uint64_t>(settings_->output.field_interval);
  if (interval == 0 || last_step_ == state.step) return {};
  if (!force && state.step % interval != 0) return {};
  DROGUE_TRY(write_files(state, averages));
  last_step_ = state.step;
  return {};
}

Result<void> FieldFiles::write_files(const FlowState& state, const FieldAverages& averages) {
  const NodalFields nodal = nodal_fields(*settings_, *mesh_, state.x, state.u);
  const double rho = settings_->density;
  const std::vector<double> points = values_of(state.x, 3);
  const std::vector<double> u = values_of(state.u, 3);
  const std::vector<double> p = values_of(state.p, 1, rho);
  const std::vector<double> vorticity = values_of(nodal.vorticity, 3);
  const std::vector<double> q = values_of(nodal.q, 1);
  const std::vector<double> eddy = values_of(nodal.eddy, 1, rho);
  std::vector<double> displacement = points;
  for (std::size_t k = 0; k < nodes_.size(); ++k)
    for (std::size_t d = 0; d < 3; ++d) displacement[3 * k + d] -= mesh_->file.points[3 * at(nodes_[k]) + d];
  io::VtuData data;
  data.points = points;
  for (const mesh::ElementBlock& block : blocks_) data.blocks.push_back(&block);
  data.point_data = {{"velocity", 3, u}, {"pressure", 1, p},          {"vorticity", 3, vorticity},
                     {"Q", 1, q},        {"eddy_viscosity", 1, eddy}, {"mesh_displacement", 3, displacement}};
  std::vector<double> means[4];
  if (!averages.velocity.empty()) {
    means[0] = values_of(averages.velocity.mean(), 3);
    means[1] = values_of(averages.velocity.rms(), 3);
    means[2] = values_of(averages.pressure.mean(), 1, rho);
    means[3] = values_of(averages.pressure.rms(), 1, rho);
    data.point_data.insert(data.point_data.end(), {{"velocity_mean", 3, means[0]},
                                                   {"velocity_rms", 3, means[1]},
                                                   {"pressure_mean", 1, means[2]},
                                                   {"pressure_rms", 1, means[3]}});
  }
  std::filesystem::path file = directory_ / fmt::format("fluid_{:06}.vtu", state.step);
  if (la::rank_count() == 1) {
    DROGUE_TRY(io::write_vtu(file, data));
    return collection_.add(state.time, file);
  }
  const auto piece = [&](int rank) {
    return directory_ / fmt::format("piece_{:06}_{}.vtu", state.step, rank);
  };
  DROGUE_TRY(la::agree(io::write_vtu(piece(la::rank()), data)));
  if (la::rank() != 0) return la::agree({});
  std::vector<std::filesystem::path> pieces;
  for (int rank = 0; rank < la::rank_count(); ++rank) pieces.push_back(piece(rank));
  file.replace_extension(".pvtu");
  Result<void> written = io::write_pvtu(file, data, pieces);
  if (written) written = collection_.add(state.time, file);
  return la::agree(written);
}

} // namespace drogue::fluid
