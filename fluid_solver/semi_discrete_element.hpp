// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fluid_solver/instant.hpp"

/// Stabilised P1 triangle or tetrahedron on a fixed mesh: 4 unknowns a node [u_x u_y u_z p] at t_{n+1}, u_z
/// without an equation in two dimensions. Terms and references: instant.hpp, with du/dt = rate u_{n+1} + h,
/// h the part of the difference formula that is known: backward Euler or the two-step formula
/// (time_difference.hpp).
namespace drogue::fluid {
inline namespace DROGUE_ISA {

template <int dim, class Real>
struct SemiDiscreteValues {
  Real x[dim + 1][dim];                         ///< corners [length]
  Real history[dim + 1][dim];                   ///< h [length/time^2]
  Real f[dim + 1][dim];                         ///< body force per mass at t_{n+1}
  Real w[dim + 1][4];                           ///< unknowns
  Real stress[dim + 1][stress_components<dim>]; ///< recovered 2 nu S
};

/// residual[a] = (F_a, C_a), and what its tangent needs.
template <int dim, class Real, class Rule>
inline void semi_discrete_residual(const SemiDiscreteValues<dim, Real>& in, double rate,
                                   const FlowParameters& parameters, const Rule& rule,
                                   Real residual[dim + 1][4], Instant<dim, Real>& s) noexcept {
  constexpr int nodes = dim + 1;
  const double convection = parameters.convection ? 1.0 : 0.0;
  InstantValues<dim, Real> v;
  for (int a = 0; a < nodes; ++a) {
    for (int d = 0; d < dim; ++d) {
      v.u[a][d] = in.w[a][d];
      v.c[a][d] = convection * in.w[a][d];
      v.a[a][d] = rate * in.w[a][d] + in.history[a][d] - in.f[a][d];
    }
    v.p[a] = in.w[a][3];
    if (parameters.viscous_residual)
      for (int i = 0; i < stress_components<dim>; ++i) v.stress[a][i] = in.stress[a][i];
  }
  InstantResidual<dim, Real> instant;
  evaluate_instant<dim>(in.x, v, 1.0, rule, 0, parameters.newton && parameters.convection,
                        parameters.viscous_residual, s, instant);
  for (int a = 0; a < nodes; ++a) {
    residual[a][2] = Real{};
    for (int d = 0; d < dim; ++d) residual[a][d] = instant.momentum[a][d];
    residual[a][3] = instant.continuity[a];
  }
}

/// Calls sink(a, b, block) for all node pairs, block[4 j + i] the derivative of residual[a][i] with respect
/// to w[b][j].
template <int dim, class Real, class Sink>
inline void semi_discrete_tangent(const Instant<dim, Real>& s, double rate, Sink&& sink) noexcept {
  constexpr int nodes = dim + 1;
  const auto du_dt = static_cast<Scalar<Real>>(rate);
  InstantTangent<dim, Real> t;
  Real block[16] = {};
  for (int a = 0; a < nodes; ++a)
    for (int b = 0; b < nodes; ++b) {
      instant_tangent<dim>(s, a, b, t);
      for (int j = 0; j < dim; ++j) {
        for (int i = 0; i < dim; ++i) block[4 * j + i] = t.momentum_u[i][j];
        block[4 * j + j] += du_dt * t.momentum_rate;
        block[4 * j + 3] = t.continuity_u[j] + du_dt * t.continuity_rate[j];
        block[12 + j] = t.momentum_p[j];
      }
      block[15] = t.continuity_p;
      sink(a, b, block);
    }
}

} // namespace DROGUE_ISA
} // namespace drogue::fluid
