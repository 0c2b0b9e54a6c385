// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fluid_solver/instant.hpp"

/// Stabilised P1 tetrahedron on a fixed mesh, backward Euler in time: 4 unknowns a node [u_x u_y u_z p] at
/// t_{n+1}. Terms and references: instant.hpp, with du/dt = (u_{n+1} - u_n)/dt.
namespace drogue::fluid {

template <class Real>
struct SemiDiscreteValues {
  Real x[4][3];   ///< corners [length]
  Real u_n[4][3]; ///< velocity at t_n
  Real f[4][3];   ///< body force per mass at t_{n+1}
  Real w[4][4];   ///< unknowns
};

/// residual[a] = (F_a, C_a); with `tangent`, calls sink(a, b, block) for the 16 node pairs, block[4 j + i]
/// the derivative of residual[a][i] with respect to w[b][j].
template <bool tangent, class Real, class Rule, class Sink>
inline void semi_discrete_element(const SemiDiscreteValues<Real>& in, double dt, const Rule& rule,
                                  Real residual[4][4], Sink&& sink) noexcept {
  const double rate = 1.0 / dt;
  InstantValues<Real> v;
  for (int a = 0; a < 4; ++a) {
    for (int d = 0; d < 3; ++d) {
      v.u[a][d] = v.c[a][d] = in.w[a][d];
      v.a[a][d] = rate * (in.w[a][d] - in.u_n[a][d]) - in.f[a][d];
    }
    v.p[a] = in.w[a][3];
  }
  Instant<Real> s;
  evaluate_instant(in.x, v, 1.0, rule, 0, s);
  for (int a = 0; a < 4; ++a) {
    for (int d = 0; d < 3; ++d) residual[a][d] = s.momentum[a][d];
    residual[a][3] = s.continuity[a];
  }
  if constexpr (tangent) {
    InstantTangent<Real> t;
    Real block[16];
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        instant_tangent(s, a, b, t);
        for (int j = 0; j < 3; ++j) {
          for (int i = 0; i < 3; ++i) block[4 * j + i] = t.momentum_u[i][j];
          block[4 * j + j] += rate * t.momentum_rate;
          block[4 * j + 3] = t.continuity_u[j] + rate * t.continuity_rate[j];
          block[12 + j] = t.momentum_p[j];
        }
        block[15] = t.continuity_p;
        sink(a, b, block);
      }
  }
}

} // namespace drogue::fluid
