// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "common/base/result.hpp"

namespace drogue::parachute {

/// Writes the structure mesh of a config. Errors (ErrorKind::config): the config has errors or no structure
/// section.
[[nodiscard]] Result<void> write_structure_mesh(const std::filesystem::path& config_file);

/// Validates a config and prints "FILE: ok".
[[nodiscard]] Result<void> check_config(const std::filesystem::path& config_file);

} // namespace drogue::parachute
