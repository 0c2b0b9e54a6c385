// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.hpp"
#include "common/base/role.hpp"

namespace drogue::mesh_mover {

/// Validates a config and its mesh, and prints "FILE: ok".
[[nodiscard]] Result<void> check(const std::filesystem::path& file, Role role);

/// Runs a config; with an endpoint as a participant of a coupled run.
[[nodiscard]] Result<void> run(const std::filesystem::path& file, const std::string& endpoint);

} // namespace drogue::mesh_mover
