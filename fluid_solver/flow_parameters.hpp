// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace drogue::fluid {

/// What the element kernels need besides nodal values.
struct FlowParameters {
  double dt = 0;          ///< time step [time]
  double nu = 0;          ///< molecular kinematic viscosity [length^2/time]
  double smagorinsky = 0; ///< Cs; 0 switches the model off
  bool lsic = true;
  bool convection = true; ///< false: the equations without c . grad u, for divergence-free starts
  /// Tangent with the derivative of the advecting velocity (Newton), or with that velocity held (Picard).
  bool newton = true;
  double tau_dt = 0;             ///< time step in tau [time]; dt unless a study of the order in time holds it
  bool viscous_residual = false; ///< r has the divergence of the recovered stress
  bool time_weight = true;       ///< the time derivative of DSD/SST's test functions weighs the residual
};

} // namespace drogue::fluid
