// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace drogue::fluid {

/// du/dt at t_{n+1} = rate u_{n+1} + at_n u_n + before u_{n-1} of the semi-discrete formulation.
struct TimeDifference {
  double rate = 0;   ///< [1/time]
  double at_n = 0;   ///< [1/time]
  double before = 0; ///< [1/time]
};

/// First order.
[[nodiscard]] constexpr TimeDifference backward_euler(double dt) {
  return {1 / dt, -1 / dt, 0};
}

/// Second order: the derivative at t_{n+1} of the parabola through the last three values, dt_before the step
/// before [hairer1993, III.5].
[[nodiscard]] constexpr TimeDifference two_step(double dt, double dt_before) {
  const double r = dt / dt_before;
  return {(1 + 2 * r) / (1 + r) / dt, -(1 + r) / dt, r * r / (1 + r) / dt};
}

} // namespace drogue::fluid
