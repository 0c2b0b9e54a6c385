// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh_mover/settings.hpp"

namespace drogue::mesh_mover {

/// Moves the mesh through all steps of its config with the boundaries' own expressions, and writes results.
/// Errors: ErrorKind::numerical names the step that failed.
/// @param remesh_program see Remesher
[[nodiscard]] Result<void> run_standalone(Case input, const std::filesystem::path& remesh_program = {});

} // namespace drogue::mesh_mover
