// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "coupler/projection/interface_quadrature.hpp"

namespace drogue::coupler {

/// What `coupler project` is asked.
struct ProjectCommand {
  std::filesystem::path from, to;   ///< meshes
  std::string from_group, to_group; ///< surfaces in them; empty: the only one
  /// Expressions of x, y, z, separated by semicolons: three, or one for the first component.
  std::string expression;
  /// A nodal field of the mesh `from` with one or three components, instead of an expression.
  std::string field;
  /// The state of a structure on the mesh `from`, instead of either (project_state.hpp).
  std::filesystem::path state;
  std::filesystem::path output = "projected.vtu";
  projection::Settings settings;
};

/// Projects a field from one surface to another as the coupler would, without any solver: as a displacement
/// (least squares) and as a traction (conservative nodal forces, and the traction recovered from them).
/// Prints how the surfaces lie on one another, errors where the field is an expression, balances of force and
/// moment, and times; writes the results on the surface `to`.
/// Errors (ErrorKind::config): what cannot be read or parsed; surfaces that do not lie on one another.
[[nodiscard]] Result<void> project(const ProjectCommand& command);

} // namespace drogue::coupler
