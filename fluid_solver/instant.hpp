// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fluid_solver/stabilisation.hpp"
#include "fluid_solver/tet_geometry.hpp"

/// The stabilised flow equations on one linear tetrahedron at one instant: what the semi-discrete element and
/// the two time points of the space-time element share.
///
/// Strong form (per mass; p is the kinematic pressure, pressure over density):
///   r = du/dt|_mesh + c . grad u + grad p - div(2 nu S) - f = 0,   div u = 0,   c = u - mesh velocity
/// The second derivatives of linear shape functions vanish, so r has no viscous part inside an element.
///
/// Weak form, w and q the test functions of node a:
///   F_a  = int N_a (du/dt + c . grad u - f) - div(w) p + 2 nu S : grad w + tau_lsic div(w) div(u)
///        + int tau (c . grad N_a) r
///   C_a  = int N_a div u + int tau grad N_a . r
///   Ft_a = int tau N_a r           (weighs the time derivative of the test function; space-time only)
/// [tezduyar1992], [stein2001, eqs. (1)-(2) and the text after them].
///
/// Every integrand is a product of linear functions and constants; the integrals are closed-form:
/// int N_a = V/4, int N_a N_b = V/20 (1 + delta_ab). No quadrature error in space.
///
/// The tangent is that of F, C, Ft with the coefficients nu, tau and tau_lsic held.
namespace drogue::fluid {

/// Nodal values at the instant.
template <class Real>
struct InstantValues {
  Real u[4][3]; ///< velocity [length/time]
  Real c[4][3]; ///< advecting velocity: u minus the mesh velocity [length/time]
  Real a[4][3]; ///< du/dt following the mesh, minus the body force per mass [length/time^2]
  Real p[4];    ///< kinematic pressure [length^2/time^2]
};

/// Everything residual and tangent have in common, computed once.
template <class Real>
struct Instant {
  TetGeometry<Real> geometry;
  Coefficients<Real> k;
  Real grad_u[3][3];
  Real weight;       ///< volume times the quadrature weight in time
  Real r_mass[4][3]; ///< int N_a r [weighted]
  Real c_mean[3];    ///< centroid value of c
  Real advect[4][4]; ///< int N_a c . grad N_b [weighted]
  Real cc[3][3];     ///< int c_i c_j [weighted]

  Real momentum[4][3];  ///< F
  Real continuity[4];   ///< C
  Real time_test[4][3]; ///< Ft
};

/// Evaluates geometry-dependent integrals and the three residuals of the element. `rule(point, geometry, c,
/// grad_u)` gives the coefficients. weight_in_time: 1, or the Gauss weight times dt.
template <class Real, class Rule>
inline void evaluate_instant(const Real x[4][3], const InstantValues<Real>& v, double weight_in_time,
                             const Rule& rule, int point, Instant<Real>& s) noexcept {
  s.geometry = tet_geometry(x);
  const auto& g = s.geometry.gradient;
  Real grad_p[3];
  Real c_sum[3];
  for (int d = 0; d < 3; ++d) {
    grad_p[d] = v.p[0] * g[0][d] + v.p[1] * g[1][d] + v.p[2] * g[2][d] + v.p[3] * g[3][d];
    c_sum[d] = v.c[0][d] + v.c[1][d] + v.c[2][d] + v.c[3][d];
    s.c_mean[d] = 0.25 * c_sum[d];
    for (int j = 0; j < 3; ++j)
      s.grad_u[d][j] = v.u[0][d] * g[0][j] + v.u[1][d] * g[1][j] + v.u[2][d] * g[2][j] + v.u[3][d] * g[3][j];
  }
  s.k = rule(point, s.geometry, s.c_mean, s.grad_u);
  const Real V = s.geometry.volume * weight_in_time;
  const Real V4 = 0.25 * V;
  const Real V20 = 0.05 * V;
  s.weight = V;

  Real inertia[4][3]; // r without grad p, nodal
  Real inertia_sum[3] = {Real{}, Real{}, Real{}};
  for (int a = 0; a < 4; ++a)
    for (int d = 0; d < 3; ++d) {
      inertia[a][d] =
          v.a[a][d] + v.c[a][0] * s.grad_u[d][0] + v.c[a][1] * s.grad_u[d][1] + v.c[a][2] * s.grad_u[d][2];
      inertia_sum[d] += inertia[a][d];
    }
  Real c_r[3][3]; // int c_k r_d
  for (int k = 0; k < 3; ++k)
    for (int d = 0; d < 3; ++d) {
      Real sum = c_sum[k] * inertia_sum[d];
      Real product = c_sum[k] * c_sum[d];
      for (int a = 0; a < 4; ++a) {
        sum += v.c[a][k] * inertia[a][d];
        product += v.c[a][k] * v.c[a][d];
      }
      c_r[k][d] = V20 * sum + V4 * c_sum[k] * grad_p[d];
      s.cc[k][d] = V20 * product;
    }
  const Real div = s.grad_u[0][0] + s.grad_u[1][1] + s.grad_u[2][2];
  const Real p_mean = 0.25 * (v.p[0] + v.p[1] + v.p[2] + v.p[3]);
  const Real isotropic = V * (s.k.tau_lsic * div - p_mean);
  for (int a = 0; a < 4; ++a) {
    for (int d = 0; d < 3; ++d) {
      const Real galerkin = V20 * (inertia_sum[d] + inertia[a][d]);
      s.r_mass[a][d] = galerkin + V4 * grad_p[d];
      Real f = galerkin + isotropic * g[a][d];
      for (int j = 0; j < 3; ++j)
        f += g[a][j] * (s.k.nu * V * (s.grad_u[d][j] + s.grad_u[j][d]) + s.k.tau * c_r[j][d]);
      s.momentum[a][d] = f;
      s.time_test[a][d] = s.k.tau * s.r_mass[a][d];
    }
    Real q = V4 * div;
    for (int d = 0; d < 3; ++d) q += s.k.tau * g[a][d] * (V4 * inertia_sum[d] + V * grad_p[d]);
    s.continuity[a] = q;
    for (int b = 0; b < 4; ++b)
      s.advect[a][b] = V20 * ((c_sum[0] + v.c[a][0]) * g[b][0] + (c_sum[1] + v.c[a][1]) * g[b][1] +
                              (c_sum[2] + v.c[a][2]) * g[b][2]);
  }
}

/// Derivatives of F_a, C_a and Ft_a with respect to node b's velocity u_j, its time derivative and its
/// pressure at the instant. A derivative that is a multiple of the identity is stored as that multiple.
template <class Real>
struct InstantTangent {
  Real momentum_u[3][3];   ///< dF_i/du_j
  Real momentum_rate;      ///< dF_i/d(du_i/dt)
  Real momentum_p[3];      ///< dF_i/dp
  Real continuity_u[3];    ///< dC/du_j
  Real continuity_rate[3]; ///< dC/d(du_j/dt)
  Real continuity_p;       ///< dC/dp
  Real time_u[3][3];       ///< dFt_i/du_j
  Real time_rate;          ///< dFt_i/d(du_i/dt)
  Real time_p[3];          ///< dFt_i/dp
};

template <class Real>
inline void instant_tangent(const Instant<Real>& s, int a, int b, InstantTangent<Real>& t) noexcept {
  const Real* ga = s.geometry.gradient[a];
  const Real* gb = s.geometry.gradient[b];
  const Real V = s.weight;
  const Real V4 = 0.25 * V;
  const Real tau = s.k.tau;
  const Real mass = V * (a == b ? 0.1 : 0.05);
  const Real ga_gb = ga[0] * gb[0] + ga[1] * gb[1] + ga[2] * gb[2];
  Real streamline{}; // int (c . grad N_a)(c . grad N_b)
  for (int i = 0; i < 3; ++i)
    streamline += ga[i] * (s.cc[i][0] * gb[0] + s.cc[i][1] * gb[1] + s.cc[i][2] * gb[2]);
  const Real c_ga = s.c_mean[0] * ga[0] + s.c_mean[1] * ga[1] + s.c_mean[2] * ga[2];
  const Real c_gb = s.c_mean[0] * gb[0] + s.c_mean[1] * gb[1] + s.c_mean[2] * gb[2];
  const Real nu_V = s.k.nu * V;
  const Real lsic_V = s.k.tau_lsic * V;
  const Real tau_V4 = tau * V4;
  const Real diagonal = s.advect[a][b] + tau * streamline + nu_V * ga_gb;
  const Real mass_advect = mass + tau * s.advect[b][a];
  const Real tau_mass = tau * mass;
  for (int j = 0; j < 3; ++j) {
    Real projected{}; // sum_i ga_i du_i/dx_j
    for (int i = 0; i < 3; ++i) {
      t.momentum_u[i][j] = nu_V * ga[j] * gb[i] + lsic_V * ga[i] * gb[j] + mass_advect * s.grad_u[i][j] +
                           tau * ga[j] * s.r_mass[b][i];
      t.time_u[i][j] = tau_mass * s.grad_u[i][j];
      projected += ga[i] * s.grad_u[i][j];
    }
    t.momentum_u[j][j] += diagonal;
    t.time_u[j][j] += tau * s.advect[a][b];
    t.momentum_p[j] = tau * V * c_ga * gb[j] - V4 * ga[j];
    t.continuity_u[j] = V4 * gb[j] + tau * V * c_gb * ga[j] + tau_V4 * projected;
    t.continuity_rate[j] = tau_V4 * ga[j];
    t.time_p[j] = tau_V4 * gb[j];
  }
  t.momentum_rate = mass_advect;
  t.continuity_p = tau * V * ga_gb;
  t.time_rate = tau_mass;
}

} // namespace drogue::fluid
