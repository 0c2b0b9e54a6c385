// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "common/base/log.hpp"
#include "common/la_krylov/session.hpp"
#include "common/mesh/msh.hpp"
#include "fluid_solver/flow_run.hpp"
#include "fluid_solver/mesh_transfer.hpp"

namespace drogue::fluid {
namespace {

/// Slabs that the flow is given to settle on its new mesh.
constexpr int settling_slabs = 3;

/// The flow of a solver on another mesh.
Result<FlowState> carried_over(const FlowState& old, const MeshTransfer& transfer, const FluidMesh& to) {
  const std::size_t n = old.p.size();
  std::vector<double> up(4 * n);
  for (std::size_t i = 0; i < n; ++i) {
    std::copy_n(old.u.data() + 3 * i, 3, up.data() + 4 * i);
    up[4 * i + 3] = old.p[i];
  }
  const auto carried = transfer.projected(up, 4);
  if (!carried) return carried.error();
  FlowState s;
  s.time = old.time;
  s.step = old.step;
  s.x = to.points;
  s.wall_velocity = transfer.at_kept_nodes(old.wall_velocity, 3);
  for (std::size_t i = 0; i < carried->size(); i += 4) {
    s.u.insert(s.u.end(), carried->data() + i, carried->data() + i + 3);
    s.p.push_back((*carried)[i + 3]);
  }
  return s;
}

TransferDefects defects_of(const FlowTotals& before, const FlowTotals& after) {
  TransferDefects d;
  double square = 0;
  for (std::size_t k = 0; k < 3; ++k) square += std::pow(after.momentum[k] - before.momentum[k], 2);
  if (before.gross_flux > 0) d.mass = std::abs(after.net_flux - before.net_flux) / before.gross_flux;
  if (before.speed > 0) d.momentum = std::sqrt(square) / before.speed;
  if (before.energy > 0) d.energy = std::abs(after.energy - before.energy) / before.energy;
  return d;
}

Result<FluidMesh> read(const std::filesystem::path& file, const std::string& hash) {
  auto mesh = mesh::read_msh(file);
  if (!mesh) return mesh.error();
  auto made = FluidMesh::create(std::move(*mesh));
  if (made && made->hash != hash)
    return config_error("{} holds the mesh {} in place of {}", file.string(), made->hash, hash);
  return made;
}

} // namespace

Result<TransferDefects> FlowRun::replace_mesh(const std::filesystem::path& file, const std::string& hash,
                                              bool restoring) {
  auto next = read(file, hash);
  if (!next) return next.error();
  if (next->boundaries != input_.mesh.boundaries)
    return config_error("{} has other boundaries than the mesh it should replace", file.string());
  if (restoring) {
    take(std::move(*next));
    return TransferDefects{};
  }
  const FlowState& old = solver_->state();
  const auto transfer = MeshTransfer::create(input_.mesh, old.x, *next);
  if (!transfer) return transfer.error();
  auto state = carried_over(old, *transfer, *next);
  if (!state) return state.error();
  const FlowTotals before = flow_totals(input_.mesh, old.x, old.u);
  const double dt = old.step_before;
  averages_.velocity.map([&](const std::vector<double>& v) { return transfer->interpolated(v, 3); });
  averages_.pressure.map([&](const std::vector<double>& v) { return transfer->interpolated(v, 1); });
  if (results_) probe_positions_ = results_->probe_positions(old.x);
  take(std::move(*next));
  solver_->set_state(std::move(*state));
  DROGUE_TRY(la::agree(results_ ? results_->place_probes(input_.mesh, probe_positions_) : Result<void>()));
  if (dt > 0) // a step was done
    DROGUE_TRY(solver_->settle(dt, input_.settings.phases.front().time_points, settling_slabs));
  const FlowState& now = solver_->state();
  return defects_of(before, flow_totals(input_.mesh, now.x, now.u));
}

void FlowRun::take(FluidMesh next) {
  solver_.reset();
  input_.mesh = std::move(next);
  solver_.emplace(input_.settings, input_.mesh);
  if (fields_) fields_->take_mesh();
}

} // namespace drogue::fluid
