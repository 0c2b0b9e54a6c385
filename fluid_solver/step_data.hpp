// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "fluid_solver/slip_walls.hpp"

namespace drogue::fluid {

/// One time step in nodal arrays in the solver's node order, the same on every rank. Pressures are kinematic.
/// In two dimensions third components are zero.
struct StepData {
  double t_n = 0;
  double dt = 0;
  int time_points = 2;                  ///< quadrature points of DSD/SST in time
  double rate = 0;                      ///< semi-discrete: du/dt = rate u_{n+1} + history [1/time]
  std::vector<double> history;          ///< {n, 3} [length/time^2]
  std::vector<double> x_n;              ///< {n, 3} mesh at t_n
  std::vector<double> x_np1;            ///< {n, 3} mesh at t_{n+1}
  std::vector<double> u_n;              ///< {n, 3} velocity at t_n^-
  std::vector<double> f_n;              ///< {n, 3} body force per mass at t_n
  std::vector<double> f_np1;            ///< {n, 3} and at t_{n+1}
  std::vector<double> wall_n;           ///< {n, 3} velocity of the walls at t_n^+; read at walls only
  std::vector<double> wall_np1;         ///< {n, 3} and at t_{n+1}^-
  std::vector<SlipDirections> slip_n;   ///< directions in which free slip holds velocities, at t_n^+
  std::vector<SlipDirections> slip_np1; ///< and at t_{n+1}^-
  /// Viscous stress per density recovered at the nodes {n, 6}, components as in stress_component(); empty
  /// where the stabilisation's residual has no viscous part. At t_n^+ and t_{n+1}^- [length^2/time^2].
  std::vector<double> stress_n, stress_np1;
  std::vector<double>
      unknowns; ///< {n, 4}: (u, p) at t_{n+1}; or {n, 8}: (u, p) at t_n^+, (u, p) at t_{n+1}^-
};

} // namespace drogue::fluid
