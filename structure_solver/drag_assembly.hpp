// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "structure_solver/assembly.hpp"
#include "structure_solver/model.hpp"

namespace drogue::structure {

/// Where drag is evaluated.
struct DragRequest {
  std::span<const double> displacement; ///< {3 nodes}
  std::span<const double> velocity;     ///< {3 nodes}
  double time = 0;
  double factor = 1; ///< on the force
  /// Adds the tangent to this matrix, when given.
  Assembler* tangent = nullptr;
  /// Derivatives of `displacement` and `velocity` with respect to the unknown.
  double displacement_scale = 1, velocity_scale = 0;
  /// With the derivatives by position (wind gradient, direction and length of a line): not symmetric. The
  /// derivative by velocity is, and always there.
  bool by_position = false;
};

/// residual -= drag, {3 nodes}.
void add_drag(const Model& model, const DragRequest& request, std::span<double> residual);

} // namespace drogue::structure
