// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/commands.hpp"

#include <fmt/core.h>

#include "common/base/log.hpp"
#include "common/mesh/msh.hpp"
#include "parachute_mesher/settings.hpp"
#include "parachute_mesher/structure_mesh.hpp"

namespace drogue::parachute {

Result<void> write_structure_mesh(const std::filesystem::path& config_file) {
  const Result<Settings> settings = load_settings(config_file);
  if (!settings) return settings.error();
  if (!settings->structure)
    return config_error("{}: error: there is no section structure {{ ... }}", config_file.string());
  const mesh::Mesh m = structure_mesh(settings->canopy, settings->rigging, *settings->structure);
  DROGUE_TRY(mesh::write_msh(settings->structure->file, m));
  for (const mesh::ElementBlock& block : m.blocks)
    spdlog::info("{}: {} elements ({})", block.group, block.count(), mesh::name(block.kind));
  spdlog::info("wrote {}: {} nodes", settings->structure->file.string(), m.node_count());
  return {};
}

Result<void> check_config(const std::filesystem::path& config_file) {
  const Result<Settings> settings = load_settings(config_file);
  if (!settings) return settings.error();
  fmt::print("{}: ok\n", config_file.string());
  return {};
}

} // namespace drogue::parachute
