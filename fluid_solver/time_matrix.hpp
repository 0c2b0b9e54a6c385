// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

namespace drogue::fluid {

/// 2 x 2, row-major.
using Matrix2 = std::array<double, 4>;

[[nodiscard]] constexpr Matrix2 operator*(const Matrix2& a, const Matrix2& b) {
  return {a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3], a[2] * b[0] + a[3] * b[2],
          a[2] * b[1] + a[3] * b[3]};
}
[[nodiscard]] constexpr Matrix2 operator+(const Matrix2& a, const Matrix2& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]};
}
[[nodiscard]] constexpr Matrix2 operator*(double s, const Matrix2& a) {
  return {s * a[0], s * a[1], s * a[2], s * a[3]};
}
[[nodiscard]] constexpr Matrix2 transposed(const Matrix2& a) {
  return {a[0], a[2], a[1], a[3]};
}
/// @pre the determinant is not zero
[[nodiscard]] constexpr Matrix2 inverse(const Matrix2& a) {
  return (1 / (a[0] * a[3] - a[1] * a[2])) * Matrix2{a[3], -a[1], -a[2], a[0]};
}

/// W of the pressure Schur complement S ~ K (x) W of the slab when inertia dominates:
///   W = tau Theta + (Theta - tau_time E)(E + J + tau_time F)^-1 (Theta + tau E^T)
/// with Theta, E, F the integrals of T T, T T', T' T' over the slab, J the jump at t_n, tau = dt/2, and
/// tau_time the same or, without the test functions' time derivative, zero. The
/// first term is PSPG's own; the middle factor the velocity block over the mass matrix, with SUPG's time
/// part; its neighbours the divergence and the gradient, each with the stabilisation's share.
[[nodiscard]] constexpr Matrix2 slab_schur_matrix(double dt, bool time_weight) {
  constexpr Matrix2 theta_over_dt{1.0 / 3, 1.0 / 6, 1.0 / 6, 1.0 / 3};
  constexpr Matrix2 E{-0.5, 0.5, -0.5, 0.5};
  constexpr Matrix2 J{1, 0, 0, 0};
  constexpr Matrix2 F_times_dt{1, -1, -1, 1};
  const double tau = dt / 2;
  const double tau_time = time_weight ? tau : 0.0;
  const Matrix2 theta = dt * theta_over_dt;
  return tau * theta + (theta + (-tau_time) * E) * inverse(E + J + (tau_time / dt) * F_times_dt) *
                           (theta + tau * transposed(E));
}

} // namespace drogue::fluid
