// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh_mover/settings.hpp"

namespace drogue::mesh_mover {

/// Moves the mesh through all steps of its config with the boundaries' own expressions, and writes results.
/// Errors: ErrorKind::numerical names the step that failed.
[[nodiscard]] Result<void> run_standalone(Case input);

} // namespace drogue::mesh_mover
