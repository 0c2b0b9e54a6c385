// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fluid_solver/simplex_geometry.hpp"
#include "fluid_solver/stabilisation.hpp"

/// The stabilised flow equations on one linear triangle or tetrahedron at one instant: what the semi-discrete
/// element and the time points of the space-time element share.
///
/// Strong form (per mass; p is the kinematic pressure, pressure over density):
///   r = du/dt|_mesh + c . grad u + grad p - div(2 nu S) - f = 0,   div u = 0,   c = u - mesh velocity
/// The second derivatives of linear shape functions vanish: inside an element r has a viscous part only where
/// the stress is recovered from nodal values (recovered_stress.hpp), which the tangent leaves out.
///
/// Weak form, w and q the test functions of node a:
///   F_a  = int N_a (du/dt + c . grad u - f) - div(w) p + 2 nu S : grad w + tau_lsic div(w) div(u)
///        + int tau (c . grad N_a) r
///   C_a  = int N_a div u + int tau grad N_a . r
///   Ft_a = int tau_time N_a r      (weighs the time derivative of the test function; space-time only)
/// [tezduyar1992], [stein2001, eqs. (1)-(2) and the text after them].
///
/// Every integrand is a product of linear functions and constants; the integrals are closed-form: with
/// m = dim + 1 nodes int N_a = V/m, int N_a N_b = V/(m (m + 1)) (1 + delta_ab). No quadrature error in space.
///
/// The tangent is that of F, C, Ft with the coefficients nu, tau, tau_time and tau_lsic held; in Picard's
/// iteration the advecting velocity c is held as well.
namespace drogue::fluid {
inline namespace DROGUE_ISA {

/// Components of a symmetric tensor and the place of its component (i, j): xx, xy, yy, xz, yz, zz.
template <int dim>
inline constexpr int stress_components = dim*(dim + 1) / 2;
[[nodiscard]] constexpr int stress_component(int i, int j) noexcept {
  return i > j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i;
}

/// Nodal values at the instant.
template <int dim, class Real>
struct InstantValues {
  Real u[dim + 1][dim]; ///< velocity [length/time]
  Real c[dim + 1][dim]; ///< advecting velocity: u minus the mesh velocity [length/time]
  Real a[dim + 1][dim]; ///< du/dt following the mesh, minus the body force per mass [length/time^2]
  Real p[dim + 1];      ///< kinematic pressure [length^2/time^2]
  Real stress[dim + 1][stress_components<dim>]; ///< recovered 2 nu S [length^2/time^2]
};

/// a . b over the dimensions of space.
template <int dim, class Real>
[[nodiscard]] inline Real dot(const Real* a, const Real* b) noexcept {
  Real sum = a[0] * b[0];
  for (int d = 1; d < dim; ++d) sum += a[d] * b[d];
  return sum;
}

/// The parts of int N_a = V mean, int N_a N_b = V pair (1 + delta_ab).
template <int dim>
inline constexpr double node_mean = 1.0 / (dim + 1);
template <int dim>
inline constexpr double node_pair = 1.0 / ((dim + 1) * (dim + 2));

/// What residual and tangent have in common, computed once.
template <int dim, class Real>
struct Instant {
  static constexpr int nodes = dim + 1;
  SimplexGeometry<dim, Real> geometry;
  Coefficients<Real> k;
  Real grad_u[dim][dim];
  Real weight;               ///< volume times the quadrature weight in time
  Real dc_grad_u[dim][dim];  ///< grad_u where the tangent lets c vary, else zero
  Real tau_dc_r[nodes][dim]; ///< tau int N_a r where it does
  Real c_mean[dim];          ///< centroid value of c
  Real advect[nodes][nodes]; ///< int N_a c . grad N_b [weighted]
  Real cc[dim][dim];         ///< int c_i c_j [weighted]
};

template <int dim, class Real>
struct InstantResidual {
  Real momentum[dim + 1][dim];  ///< F
  Real continuity[dim + 1];     ///< C
  Real time_test[dim + 1][dim]; ///< Ft
};

/// Evaluates geometry-dependent integrals and the three residuals of the element. `rule(point, geometry, c,
/// grad_u)` gives the coefficients. weight_in_time: 1, or the Gauss weight times dt. vary_c: whether the
/// tangent is to have the derivative with respect to c. with_stress: whether r has the recovered stress;
/// without, v.stress is not read.
template <int dim, class Real, class Rule>
inline void evaluate_instant(const Real (*x)[dim], const InstantValues<dim, Real>& v, double weight_in_time,
                             const Rule& rule, int point, bool vary_c, bool with_stress,
                             Instant<dim, Real>& s, InstantResidual<dim, Real>& residual) noexcept {
  constexpr int nodes = dim + 1;
  s.geometry = simplex_geometry(x);
  const auto& g = s.geometry.gradient;
  Real grad_p[dim];
  Real c_sum[dim];
  for (int d = 0; d < dim; ++d) {
    grad_p[d] = v.p[0] * g[0][d];
    c_sum[d] = v.c[0][d];
    for (int a = 1; a < nodes; ++a) {
      grad_p[d] += v.p[a] * g[a][d];
      c_sum[d] += v.c[a][d];
    }
    s.c_mean[d] = node_mean<dim> * c_sum[d];
    for (int j = 0; j < dim; ++j) {
      s.grad_u[d][j] = v.u[0][d] * g[0][j];
      for (int a = 1; a < nodes; ++a) s.grad_u[d][j] += v.u[a][d] * g[a][j];
    }
  }
  s.k = rule(point, s.geometry, s.c_mean, s.grad_u);
  const Real V = s.geometry.volume * weight_in_time;
  const Real V_mean = node_mean<dim> * V;
  const Real V_pair = node_pair<dim> * V;
  s.weight = V;

  Real gradients[dim]; // of r: grad p - div(2 nu S), constant in the element
  for (int d = 0; d < dim; ++d) gradients[d] = grad_p[d];
  if (with_stress)
    for (int d = 0; d < dim; ++d)
      for (int a = 0; a < nodes; ++a)
        for (int j = 0; j < dim; ++j) gradients[d] -= v.stress[a][stress_component(d, j)] * g[a][j];
  Real inertia[nodes][dim]; // the rest of r, nodal
  Real inertia_sum[dim] = {};
  for (int a = 0; a < nodes; ++a)
    for (int d = 0; d < dim; ++d) {
      inertia[a][d] = v.a[a][d] + dot<dim>(v.c[a], s.grad_u[d]);
      inertia_sum[d] += inertia[a][d];
    }
  Real c_r[dim][dim]; // int c_k r_d
  for (int k = 0; k < dim; ++k)
    for (int d = 0; d < dim; ++d) {
      Real sum = c_sum[k] * inertia_sum[d];
      Real product = c_sum[k] * c_sum[d];
      for (int a = 0; a < nodes; ++a) {
        sum += v.c[a][k] * inertia[a][d];
        product += v.c[a][k] * v.c[a][d];
      }
      c_r[k][d] = V_pair * sum + V_mean * c_sum[k] * gradients[d];
      s.cc[k][d] = V_pair * product;
    }
  const double vary = vary_c ? 1.0 : 0.0;
  for (int k = 0; k < dim; ++k)
    for (int d = 0; d < dim; ++d) s.dc_grad_u[k][d] = vary * s.grad_u[k][d];
  Real div = s.grad_u[0][0];
  for (int d = 1; d < dim; ++d) div += s.grad_u[d][d];
  Real p_sum = v.p[0];
  for (int a = 1; a < nodes; ++a) p_sum += v.p[a];
  const Real isotropic = V * (s.k.tau_lsic * div - node_mean<dim> * p_sum);
  for (int a = 0; a < nodes; ++a) {
    for (int d = 0; d < dim; ++d) {
      const Real galerkin = V_pair * (inertia_sum[d] + inertia[a][d]);
      const Real r_mass = galerkin + V_mean * gradients[d]; // int N_a r
      Real f = galerkin + isotropic * g[a][d];
      for (int j = 0; j < dim; ++j)
        f += g[a][j] * (s.k.nu * V * (s.grad_u[d][j] + s.grad_u[j][d]) + s.k.tau * c_r[j][d]);
      residual.momentum[a][d] = f;
      residual.time_test[a][d] = s.k.tau_time * r_mass;
      s.tau_dc_r[a][d] = vary * s.k.tau * r_mass;
    }
    Real q = V_mean * div;
    for (int d = 0; d < dim; ++d) q += s.k.tau * g[a][d] * (V_mean * inertia_sum[d] + V * gradients[d]);
    residual.continuity[a] = q;
    for (int b = 0; b < nodes; ++b) {
      Real sum = (c_sum[0] + v.c[a][0]) * g[b][0];
      for (int d = 1; d < dim; ++d) sum += (c_sum[d] + v.c[a][d]) * g[b][d];
      s.advect[a][b] = V_pair * sum;
    }
  }
}

/// Derivatives of F_a and C_a with respect to node b's velocity u_j, its time derivative and its pressure at
/// the instant. A derivative that is a multiple of the identity is stored as that multiple.
template <int dim, class Real>
struct InstantTangent {
  Real momentum_u[dim][dim]; ///< dF_i/du_j
  Real momentum_rate;        ///< dF_i/d(du_i/dt)
  Real momentum_p[dim];      ///< dF_i/dp
  Real continuity_u[dim];    ///< dC/du_j
  Real continuity_rate[dim]; ///< dC/d(du_j/dt)
  Real continuity_p;         ///< dC/dp
};

template <int dim, class Real>
inline void instant_tangent(const Instant<dim, Real>& s, int a, int b,
                            InstantTangent<dim, Real>& t) noexcept {
  using Number = Scalar<Real>;
  const Real* ga = s.geometry.gradient[a];
  const Real* gb = s.geometry.gradient[b];
  const Real V = s.weight;
  const Real V_mean = Number(node_mean<dim>) * V;
  const Real tau = s.k.tau;
  const Real mass = V * Number(node_pair<dim> * (a == b ? 2.0 : 1.0));
  const Real ga_gb = dot<dim>(ga, gb);
  Real streamline{}; // int (c . grad N_a)(c . grad N_b)
  for (int i = 0; i < dim; ++i) streamline += ga[i] * dot<dim>(s.cc[i], gb);
  const Real c_ga = dot<dim>(s.c_mean, ga);
  const Real c_gb = dot<dim>(s.c_mean, gb);
  const Real nu_V = s.k.nu * V;
  const Real lsic_V = s.k.tau_lsic * V;
  const Real tau_V_mean = tau * V_mean;
  const Real diagonal = s.advect[a][b] + tau * streamline + nu_V * ga_gb;
  const Real mass_advect = mass + tau * s.advect[b][a];
  for (int j = 0; j < dim; ++j) {
    Real projected{}; // sum_i ga_i du_i/dx_j
    for (int i = 0; i < dim; ++i) {
      t.momentum_u[i][j] = nu_V * ga[j] * gb[i] + lsic_V * ga[i] * gb[j] + mass_advect * s.dc_grad_u[i][j] +
                           ga[j] * s.tau_dc_r[b][i];
      projected += ga[i] * s.dc_grad_u[i][j];
    }
    t.momentum_u[j][j] += diagonal;
    t.momentum_p[j] = tau * V * c_ga * gb[j] - V_mean * ga[j];
    t.continuity_u[j] = V_mean * gb[j] + tau * V * c_gb * ga[j] + tau_V_mean * projected;
    t.continuity_rate[j] = tau_V_mean * ga[j];
  }
  t.momentum_rate = mass_advect;
  t.continuity_p = tau * V * ga_gb;
}

} // namespace DROGUE_ISA
} // namespace drogue::fluid
