// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/program.hpp"

#include <cstdlib>
#include <string_view>

#include "common/la_direct/direct_solver.hpp"
#include "mesh_mover/mesh_participant.hpp"
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

/// Under mpiexec every rank would do the same work and write the same files.
Result<void> check_alone() {
  const char* ranks = std::getenv("OMPI_COMM_WORLD_SIZE");
  if (ranks && std::string_view(ranks) != "1")
    return config_error(
        "mesh_mover works in one process; it was started on {} ranks: start it without mpiexec", ranks);
  return {};
}

} // namespace

Result<void> check(const std::filesystem::path& file, Role role) {
  const auto input = load_whole_case(file, role);
  if (!input) return input.error();
  fmt::print("{}: ok\n", file.string());
  return {};
}

Result<void> run(const std::filesystem::path& file, const std::string& endpoint) {
  DROGUE_TRY(check_alone());
  la::use_one_blas_thread();
  auto input = load_whole_case(file, endpoint.empty() ? Role::alone : Role::participant);
  if (!input) return input.error();
  if (endpoint.empty()) return run_standalone(std::move(*input));
  MeshParticipant solver(std::move(*input));
  return participant::serve(solver, participant::serve_options_from_environment(endpoint));
}

} // namespace drogue::mesh_mover
