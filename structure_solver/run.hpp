// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "common/base/result.hpp"
#include "structure_solver/case.hpp"

namespace drogue::structure {

/// Runs a case alone: `steps` steps of dynamics or of statics, or damped dynamics until the forces balance.
/// Writes the results and, when asked for, the final state. SIGINT and SIGTERM end the run after the current
/// step, with its results and final state written.
///
/// A run that fails leaves its last good state as last_good.state beside the results.
///
/// Errors: numerical when Newton does not converge (static: even at the smallest step) or the static run does
/// not balance within largest_time; interrupted.
[[nodiscard]] Result<void> run(const Case& c);

/// load_case and run.
[[nodiscard]] Result<void> run_file(const std::filesystem::path& file);

} // namespace drogue::structure
