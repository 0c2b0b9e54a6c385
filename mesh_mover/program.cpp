// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/program.hpp"

#include "mesh_mover/mesh_participant.hpp"
#include "mesh_mover/standalone.hpp"

namespace drogue::mesh_mover {
namespace {

Result<Case> load_whole_case(const std::filesystem::path& file) {
  auto input = load_case(file);
  if (!input) return input;
  // What only the mesh and the boundaries together can tell.
  if (auto motion = BoundaryMotion::create(input->mesh, input->settings.boundaries); !motion)
    return config_error("{}: error: {}", file.string(), motion.error().message);
  return input;
}

} // namespace

Result<void> check(const std::filesystem::path& file) {
  const auto input = load_whole_case(file);
  if (!input) return input.error();
  fmt::print("{}: ok\n", file.string());
  return {};
}

Result<void> run(const std::filesystem::path& file, const std::string& endpoint) {
  auto petsc = PetscSession::start();
  if (!petsc) return petsc.error();
  auto input = load_whole_case(file);
  if (!input) return input.error();
  if (endpoint.empty()) return run_standalone(std::move(*input));
  MeshParticipant solver(std::move(*input));
  return participant::serve(solver, participant::serve_options_from_environment(endpoint));
}

} // namespace drogue::mesh_mover
