// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "common/base/result.hpp"
#include "structure_solver/model.hpp"

namespace drogue::structure {

/// Prescribed motion of one equation at one time.
struct HeldMotion {
  std::size_t equation = 0; ///< 3 node + component
  double u = 0, v = 0, a = 0;
};

/// Step of the difference quotients, relative to the time step.
constexpr double held_difference = 0.25;

/// The motion of all held equations at time t. Velocity and acceleration are the derivatives of the
/// expressions by central differences of fourth order with step `h` (zero for a constant to the last bit);
/// zero where the expression has no value before or after t.
/// Errors (numerical): a displacement that is not finite; with the group.
[[nodiscard]] Result<std::vector<HeldMotion>> held_motion(const Model& model, double t, double h);

} // namespace drogue::structure
