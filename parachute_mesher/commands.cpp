// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/commands.hpp"

#include <cstdio>

#include <fmt/core.h>

#include "common/base/log.hpp"
#include "common/io/state_file.hpp"
#include "common/mesh/msh.hpp"
#include "common/meshing/quality.hpp"
#include "parachute_mesher/fluid_mesh.hpp"
#include "parachute_mesher/info.hpp"
#include "parachute_mesher/settings.hpp"
#include "parachute_mesher/structure_mesh.hpp"

namespace drogue::parachute {
namespace {

namespace fs = std::filesystem;

Error missing_section(const fs::path& config_file, const char* section) {
  return config_error("{}: error: there is no section {} {{ ... }}", config_file.string(), section);
}

Result<std::vector<double>> read_displacement(const fs::path& file, const mesh::Mesh& structure) {
  const Result<io::State> state = io::read_state(file);
  if (!state) return state.error();
  if (state->mesh_hash != mesh::hash(structure))
    return config_error("{} is the state of another mesh than the structure_mesh of the config",
                        file.string());
  const io::StateArray* displacement = state->find("displacement");
  if (displacement == nullptr || displacement->values.size() != structure.points.size())
    return config_error(
        "{} is not a state of the structure: it has no array \"displacement\" of shape {{{}, 3}}",
        file.string(), structure.node_count());
  return displacement->values;
}

void log_fluid_mesh(const FluidMeshResult& made) {
  const meshing::MembraneVolume& volume = made.volume;
  const auto quality = meshing::summarise_quality(volume.mesh.points, volume.mesh.tets);
  spdlog::info("canopy: {} nodes doubled, {} single on the free edges", volume.doubling.doubled_nodes,
               volume.doubling.single_nodes);
  spdlog::info("repair: {} tetrahedra spanned the canopy, {} edges split, {} moves of nodes",
               volume.split.tets_before, volume.split.edges_split, volume.smoothing_moves);
  spdlog::info(
      "quality: smallest dihedral angle {:.2f} degrees, smallest mean ratio {:.3f}, {} tetrahedra below 10 "
      "degrees",
      quality.smallest_angle, quality.smallest_mean_ratio, quality.below_10_degrees);
}

} // namespace

Result<void> write_structure_mesh(const fs::path& config_file) {
  const Result<Settings> settings = load_settings(config_file);
  if (!settings) return settings.error();
  if (!settings->structure) return missing_section(config_file, "structure");
  const mesh::Mesh m = structure_mesh(settings->canopy, settings->rigging, *settings->structure);
  DROGUE_TRY(mesh::write_msh(settings->structure->file, m));
  for (const mesh::ElementBlock& block : m.blocks)
    spdlog::info("{}: {} x {}", block.group, block.count(), mesh::name(block.kind));
  spdlog::info("wrote {}: {} nodes", settings->structure->file.string(), m.node_count());
  return {};
}

Result<void> write_fluid_mesh(const fs::path& config_file) {
  const Result<Settings> settings = load_settings(config_file);
  if (!settings) return settings.error();
  if (!settings->fluid) return missing_section(config_file, "fluid");
  const FluidSettings& fluid = *settings->fluid;
  const Result<mesh::Mesh> structure = mesh::read_msh(fluid.structure_mesh);
  if (!structure) return structure.error();
  const Result<std::vector<double>> displacement = read_displacement(fluid.structure_state, *structure);
  if (!displacement) return displacement.error();
  const Result<CanopySurface> surface =
      inflated_canopy(settings->canopy, fluid.rows, *structure, *displacement);
  if (!surface) return surface.error();
  const Result<FluidMeshResult> made = fluid_mesh(settings->canopy, fluid, *surface);
  if (!made) return made.error();
  log_fluid_mesh(*made);
  DROGUE_TRY(mesh::write_msh(fluid.file, made->mesh));
  spdlog::info("wrote {}: {} nodes, {} tetrahedra", fluid.file.string(), made->mesh.node_count(),
               made->volume.mesh.tets.size());
  return {};
}

Result<void> print_info(const fs::path& mesh_file) {
  const Result<mesh::Mesh> m = mesh::read_msh(mesh_file);
  if (!m) return m.error();
  fmt::print("{}\n{}", mesh_file.string(), describe(*m));
  std::fflush(stdout);
  const Result<void> checked = check(*m);
  if (!checked) return numerical_error("{}: {}", mesh_file.string(), checked.error().message);
  return {};
}

Result<void> check_config(const fs::path& config_file) {
  const Result<Settings> settings = load_settings(config_file);
  if (!settings) return settings.error();
  fmt::print("{}: ok\n", config_file.string());
  return {};
}

} // namespace drogue::parachute
