// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "common/base/result.hpp"
#include "coupler/project/project.hpp"

namespace drogue::coupler {

/// Carries the whole state of a structure (displacement, velocity, acceleration; command.state, on the mesh
/// command.from) over to another mesh of it, and writes it to command.output: a run of the structure solver
/// on command.to can start there, as the incompatible case of [stein2001] does from the compatible
/// equilibrium.
/// On the surface by least squares [stein2001, eq. 4]; nodes of lines beside it take the value at the closest
/// point, in the reference configuration, of the lines of the same group. Prints what the surface misses.
/// Errors (ErrorKind::config): what cannot be read; a state of another mesh; surfaces or lines that do not
/// lie on one another; a node that is neither on the surface nor on a line.
[[nodiscard]] Result<void> project_state(const ProjectCommand& command);

} // namespace drogue::coupler
