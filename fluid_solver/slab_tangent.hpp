// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fluid_solver/instant.hpp"
#include "fluid_solver/slab_rule.hpp"

/// The tangent of the space-time element (space_time_element.hpp) from what its residual evaluated at the
/// time points k. With T_al^k the test and trial functions in time there, D_al = -1/dt, 1/dt their
/// derivatives, and dF, dC, dFt the derivatives of F_a, C_a, Ft_a of instant.hpp with respect to node b's
/// velocity u_j, its time derivative u_j' and its pressure p at the instant:
///   dR_(a,al)^u / du_(b,be) = sum_k T_al (T_be dF/du + D_be dF/du') + D_al (T_be dFt/du + D_be dFt/du')
///                             + delta_al0 delta_be0 int_{Omega(t_n)} N_a N_b
///   dR_(a,al)^u / dp_(b,be) = sum_k T_be (T_al dF/dp + D_al dFt/dp)
///   dR_(a,al)^p / du_(b,be) = sum_k T_al (T_be dC/du + D_be dC/du')
///   dR_(a,al)^p / dp_(b,be) = sum_k T_al T_be dC/dp
/// where, with g_a the gradient of N_a, G_ij = du_i/dx_j (zero in Picard's iteration), M_ab = int N_a N_b,
/// A_ab = int N_a c . grad N_b, Y_ab = int (c . g_a)(c . g_b), R_b = int N_b r,
///   dF_i/du_j  = nu V g_aj g_bi + lsic V g_ai g_bj + tau g_aj R_bi + (M_ab + tau A_ba) G_ij
///                + delta_ij (A_ab + tau Y_ab + nu V g_a . g_b)
///   dF_i/du_j' = delta_ij (M_ab + tau A_ba)        dF_i/dp = tau V (c . g_a) g_bi - V/m g_ai
///   dC/du_j    = V/m g_bj + tau V (c . g_b) g_aj + tau V/m g_ai G_ij
///   dC/du_j'   = tau V/m g_aj                      dC/dp   = tau V g_a . g_b
///   dFt = tau_time (M_ab G_ij + delta_ij A_ab, delta_ij M_ab, V/m g_bi)
/// Everything that depends on one node alone is formed once an element, sums over the time points are taken
/// before products with what does not depend on them.
namespace drogue::fluid {
inline namespace DROGUE_ISA {

/// What the residual leaves for the tangent.
template <int dim, int points, class Real>
struct SlabInstants {
  Instant<dim, Real> point[points];
  Real jump; ///< int N_a N_b at t_n, a != b
};

template <int dim, int points, class Real>
class SlabTangent {
 public:
  SlabTangent(const SlabInstants<dim, points, Real>& s, double dt) noexcept : s_(s), rate_(Number(1.0 / dt)) {
    for (int k = 0; k < points; ++k) prepare(k);
    sum_over_points();
  }

  /// block[8 j + i]: the derivative of residual[a][i] with respect to w[b][j]. Entries of a third component
  /// in two dimensions are left alone.
  void block(int a, int b, Real block[64]) const noexcept {
    Real rate[2][2] = {};
    Real advected[2][2][points]; // factor of G_ij
    rate[0][0] = s_.jump * Number(a == b ? 2.0 : 1.0);
    Real uu[pairs][dim][dim];
    Real pp[pairs];
    for (int k = 0; k < points; ++k) {
      const Instant<dim, Real>& s = s_.point[k];
      const Factors& f = f_[k];
      const Real* ga = s.geometry.gradient[a];
      const Real* gb = s.geometry.gradient[b];
      const Real mass = a == b ? Number(2.0) * f.mass : f.mass;
      const Real mass_advect = mass + s.k.tau * s.advect[b][a];
      const Real diagonal = s.advect[a][b] + dot<dim>(ga, f.diffusion[b]);
      const Real continuity = f.tau_V * dot<dim>(ga, gb);
      for (int al = 0; al < 2; ++al) {
        const Real test = T(al, k) * mass_advect + sign(al) * (f.tau_rate * mass);
        const Real trial = T(al, k) * diagonal + sign(al) * (f.tau_rate * s.advect[a][b]);
        for (int be = 0; be < 2; ++be) {
          advected[al][be][k] = T(be, k) * test;
          rate[al][be] += T(be, k) * trial + (sign(be) * rate_) * test;
        }
      }
      for (int pair = 0; pair < pairs; ++pair) {
        const Number TT = T(pair / 2, k) * T((pair + 1) / 2, k);
        pp[pair] = k == 0 ? TT * continuity : pp[pair] + TT * continuity;
      }
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j) {
          const Real product = ga[j] * f.column[b][i] + f.lsic[a][i] * gb[j];
          for (int pair = 0; pair < pairs; ++pair) {
            const Number TT = T(pair / 2, k) * T((pair + 1) / 2, k);
            uu[pair][i][j] = k == 0 ? TT * product : uu[pair][i][j] + TT * product;
          }
        }
    }
    for (int be = 0; be < 2; ++be)
      for (int al = 0; al < 2; ++al) {
        const int pair = al + be; // both 0, one of each, both 1
        Real* q = block + 32 * be + 4 * al;
        for (int j = 0; j < dim; ++j) {
          Real momentum_p = -mean_[a][pair][j];
          Real continuity_u = mean_[b][pair][j] + projected_[a][pair][j];
          for (int k = 0; k < points; ++k) {
            momentum_p += f_[k].momentum_p[al][a] * f_[k].trial[be][b][j];
            continuity_u += f_[k].continuity_u[be][b] * f_[k].trial[al][a][j];
          }
          q[24 + j] = momentum_p;
          q[8 * j + 3] = continuity_u;
          for (int i = 0; i < dim; ++i) {
            Real value = uu[pair][i][j];
            if (i == j) value += rate[al][be];
            for (int k = 0; k < points; ++k) value += advected[al][be][k] * s_.point[k].dc_grad_u[i][j];
            q[8 * j + i] = value;
          }
        }
        q[27] = pp[pair];
      }
  }

 private:
  using Number = Scalar<Real>;
  static constexpr int nodes = dim + 1;
  static constexpr int pairs = 3; ///< products of two functions in time: T_0 T_0, T_0 T_1, T_1 T_1

  /// At one time point.
  struct Factors {
    Real tau_V;                  ///< tau V
    Real tau_rate;               ///< tau_time / dt
    Real mass;                   ///< int N_a N_b, a != b
    Real lsic[nodes][dim];       ///< lsic V g_a
    Real column[nodes][dim];     ///< nu V g_b + tau R_b
    Real diffusion[nodes][dim];  ///< nu V g_b + tau int c (c . g_b)
    Real trial[2][nodes][dim];   ///< T_be g_b
    Real momentum_p[2][nodes];   ///< T_al tau V (c . g_a) + D_al tau_time V/m
    Real continuity_u[2][nodes]; ///< T_be tau V (c . g_b) + D_be tau V/m
  };

  static constexpr Number T(int al, int k) noexcept {
    constexpr SlabRule<points> slab;
    return Number(al == 0 ? 1.0 - slab.theta[k] : slab.theta[k]);
  }
  static constexpr Number sign(int al) noexcept { return al == 0 ? Number(-1) : Number(1); }

  void prepare(int k) noexcept {
    const Instant<dim, Real>& s = s_.point[k];
    Factors& f = f_[k];
    const Real V = s.weight;
    const Real V_mean = Number(node_mean<dim>) * V;
    const Real nu_V = s.k.nu * V;
    const Real lsic_V = s.k.tau_lsic * V;
    f.tau_V = s.k.tau * V;
    f.tau_rate = s.k.tau_time * rate_;
    f.mass = Number(node_pair<dim>) * V;
    const Real test = f.tau_rate * V_mean;
    const Real trial = s.k.tau * rate_ * V_mean;
    for (int b = 0; b < nodes; ++b) {
      const Real* g = s.geometry.gradient[b];
      const Real along = f.tau_V * dot<dim>(s.c_mean, g);
      for (int al = 0; al < 2; ++al) {
        f.momentum_p[al][b] = T(al, k) * along + sign(al) * test;
        f.continuity_u[al][b] = T(al, k) * along + sign(al) * trial;
        for (int d = 0; d < dim; ++d) f.trial[al][b][d] = T(al, k) * g[d];
      }
      for (int d = 0; d < dim; ++d) {
        f.lsic[b][d] = lsic_V * g[d];
        f.column[b][d] = nu_V * g[d] + s.tau_dc_r[b][d];
        f.diffusion[b][d] = nu_V * g[d] + s.k.tau * dot<dim>(s.cc[d], g);
      }
    }
  }

  void sum_over_points() noexcept {
    for (int a = 0; a < nodes; ++a)
      for (int pair = 0; pair < pairs; ++pair)
        for (int j = 0; j < dim; ++j) {
          Real mean{};
          Real projected{};
          for (int k = 0; k < points; ++k) {
            const Instant<dim, Real>& s = s_.point[k];
            const Real* g = s.geometry.gradient[a];
            const Number TT = T(pair / 2, k) * T((pair + 1) / 2, k) * Number(node_mean<dim>);
            Real sum = g[0] * s.dc_grad_u[0][j];
            for (int i = 1; i < dim; ++i) sum += g[i] * s.dc_grad_u[i][j];
            mean += TT * s.weight * g[j];
            projected += TT * f_[k].tau_V * sum;
          }
          mean_[a][pair][j] = mean;
          projected_[a][pair][j] = projected;
        }
  }

  const SlabInstants<dim, points, Real>& s_;
  Number rate_; ///< 1/dt
  Factors f_[points];
  Real mean_[nodes][pairs][dim];      ///< sum_k T T V/m g_a
  Real projected_[nodes][pairs][dim]; ///< sum_k T T tau V/m g_ai G_ij
};

/// Calls sink(a, b, block) for all node pairs.
template <int dim, int points, class Real, class Sink>
inline void space_time_tangent(const SlabInstants<dim, points, Real>& s, double dt, Sink&& sink) noexcept {
  const SlabTangent<dim, points, Real> tangent(s, dt);
  Real block[64] = {};
  for (int a = 0; a <= dim; ++a)
    for (int b = 0; b <= dim; ++b) {
      tangent.block(a, b, block);
      sink(a, b, block);
    }
}

} // namespace DROGUE_ISA
} // namespace drogue::fluid
