// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "common/base/result.hpp"

namespace drogue::parachute {

/// Writes the structure mesh of a config. Errors (ErrorKind::config): the config has errors or no structure
/// section.
[[nodiscard]] Result<void> write_structure_mesh(const std::filesystem::path& config_file);

/// Writes the fluid mesh of a config around the inflated canopy; nothing is written unless the mesh passes
/// every check. Errors: ErrorKind::config when the config has errors or no fluid section, or the structure's
/// mesh and state are missing or do not belong together; ErrorKind::numerical when the volume cannot be
/// meshed.
[[nodiscard]] Result<void> write_fluid_mesh(const std::filesystem::path& config_file);

/// Prints what a mesh holds, and its quality. Errors: ErrorKind::config when it cannot be read;
/// ErrorKind::numerical when it fails a check.
[[nodiscard]] Result<void> print_info(const std::filesystem::path& mesh_file);

/// Validates a config and prints "FILE: ok".
[[nodiscard]] Result<void> check_config(const std::filesystem::path& config_file);

} // namespace drogue::parachute
