// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/base/result.hpp"
#include "fluid_solver/flow_run.hpp"

namespace drogue::fluid {

/// Runs the phases one after the other. Errors (ErrorKind::numerical): a step that fails, for instance
/// because its residual stays above the settings' failure tolerance; interrupted: a signal came. Fields and
/// final state of the last good step are written in any case. @note Collective
[[nodiscard]] Result<void> run_standalone(Case& input, const std::filesystem::path& remesh_program = {});

} // namespace drogue::fluid
