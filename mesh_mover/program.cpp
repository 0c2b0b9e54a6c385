// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/program.hpp"

#include <optional>
#include <utility>

#include "common/la_direct/direct_solver.hpp"
#include "common/la_krylov/session.hpp"
#include "mesh_mover/mesh_participant.hpp"
#include "mesh_mover/shared_extension.hpp"
#include "mesh_mover/standalone.hpp"

namespace drogue::mesh_mover {
namespace {

Result<Case> load_whole_case(const std::filesystem::path& file, Role role) {
  auto input = load_case(file, role);
  if (!input) return input;
  // What only the mesh and the boundaries together can tell.
  const Cells cells = cells_of(input->mesh);
  const auto shapes = initial_shapes(input->mesh.points, cells);
  if (!shapes) return config_error("{}: error: {}", file.string(), shapes.error().message);
  const auto motion = BoundaryMotion::create(input->mesh, cells.dimension, input->settings.boundaries);
  if (!motion) return config_error("{}: error: {}", file.string(), motion.error().message);
  return input;
}

/// Everything but the shared work of the other ranks. `pids` of all ranks.
Result<void> run_on_first_rank(const std::filesystem::path& file, const std::string& endpoint,
                               std::vector<std::int64_t> pids) {
  auto input = load_whole_case(file, endpoint.empty() ? Role::alone : Role::participant);
  if (!input) return input.error();
  std::error_code ignored;
  const auto itself = std::filesystem::read_symlink("/proc/self/exe", ignored);
  if (endpoint.empty()) return run_standalone(std::move(*input), itself);
  MeshParticipant solver(std::move(*input), std::move(pids), itself);
  return participant::serve(solver, participant::serve_options_from_environment(endpoint));
}

} // namespace

Result<void> check(const std::filesystem::path& file, Role role) {
  const auto input = load_whole_case(file, role);
  if (!input) return input.error();
  fmt::print("{}: ok\n", file.string());
  return {};
}

Result<void> run(const std::filesystem::path& file, const std::string& endpoint) {
  la::use_one_blas_thread();
  std::optional<la::Session> session; // for one rank there is nothing to start
  if (la::started_on_ranks()) {
    auto started = la::Session::start();
    if (!started) return started.error();
    session.emplace(std::move(*started));
  }
  auto pids = la::process_ids();
  if (la::rank() > 0) {
    serve_extensions();
    return {};
  }
  const auto done = run_on_first_rank(file, endpoint, std::move(pids));
  stop_other_ranks();
  return done;
}

} // namespace drogue::mesh_mover
