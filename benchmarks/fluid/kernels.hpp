// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "fluid_solver/fluid_mesh.hpp"

namespace drogue::bench {

/// Rows for the parts of a linear iteration and of an assembly on one rank, beside the limits that memory and
/// arithmetic set. unknowns: 4 or 8 a node. Returns the seconds of a Jacobian's assembly.
template <int unknowns>
double kernel_rows(const fluid::FluidMesh& mesh, const std::string& name);

} // namespace drogue::bench
