// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.hpp"
#include "common/base/role.hpp"

namespace drogue::fluid {

/// Validates a config and its mesh; says so on standard output.
[[nodiscard]] Result<void> check(const std::filesystem::path& file, Role role);
/// Runs a config: alone when `endpoint` is empty, else as a participant. @note Collective
[[nodiscard]] Result<void> run(const std::filesystem::path& file, const std::string& endpoint);

} // namespace drogue::fluid
