// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>
#include <vector>

#include "fluid_solver/flow_solver.hpp"

namespace drogue::fluid {

/// Force of the fluid on a group of boundaries [force].
struct SurfaceForce {
  /// Minus the sum of the momentum residual over the boundaries' nodes: what the weak form itself exerts. Of
  /// a DSD/SST step it is the mean of the slab, inertia of the wall layer included; it rings where the
  /// end-of-slab pressure is smooth.
  std::array<double, 3> reaction{};
  std::array<double, 3> pressure{}; ///< integral of p n at t_{n+1}
  std::array<double, 3> viscous{};  ///< integral of the viscous traction at t_{n+1}
  /// Integral of (x - x_0) x (p n + viscous traction) at t_{n+1}, exact on linear faces; x_0 the point of the
  /// report [force times length].
  std::array<double, 3> moment{};

  [[nodiscard]] std::array<double, 3> total() const {
    return {pressure[0] + viscous[0], pressure[1] + viscous[1], pressure[2] + viscous[2]};
  }
};

/// One entry for each of the settings' force reports. @pre finish() of this step. @note Collective
[[nodiscard]] std::vector<SurfaceForce> surface_forces(const Settings& settings, const FluidMesh& mesh,
                                                       const FlowSolver& solver);

} // namespace drogue::fluid
