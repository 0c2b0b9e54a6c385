// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fluid_solver/slab_tangent.hpp"

/// DSD/SST: P1 triangle or tetrahedron in space times linear, discontinuous in time, on the slab between the
/// mesh at t_n and the mesh at t_{n+1} [tezduyar1992], [stein2001]. 8 unknowns a node: (u, p) at t_n^+ and
/// (u, p) at t_{n+1}^-; u_z has no equation in two dimensions.
///
/// Test functions N_a(x, t) T_al(t), al = 0, 1, T_0 = 1 - theta, T_1 = theta. The nodes move with the mesh,
/// so d(N_a T_al)/dt + u . grad(N_a T_al) = N_a T_al' + T_al c . grad N_a, and du/dt following the mesh is
/// (u_{n+1} - u_n)/dt nodewise. With F, C, Ft of instant.hpp:
///   R_(a,al)^u = int_dt (T_al F_a + T_al' Ft_a) dt  +  delta_al0 int_{Omega(t_n)} N_a (u_n^+ - u_n^-)
///   R_(a,al)^p = int_dt T_al C_a dt
/// Two or three Gauss points in time; space integrals are exact at each. The moving mesh enters through the
/// geometry and through c alone: fields linear in x stay exact on any moving mesh.
namespace drogue::fluid {
inline namespace DROGUE_ISA {

template <int dim, class Real>
struct SpaceTimeValues {
  Real x_n[dim + 1][dim];                           ///< corners at t_n [length]
  Real x_np1[dim + 1][dim];                         ///< corners at t_{n+1}
  Real u_n[dim + 1][dim];                           ///< u_n^-, end of the slab before
  Real f_n[dim + 1][dim];                           ///< body force per mass at t_n
  Real f_np1[dim + 1][dim];                         ///< body force per mass at t_{n+1}
  Real w[dim + 1][8];                               ///< unknowns
  Real stress_n[dim + 1][stress_components<dim>];   ///< recovered 2 nu S at t_n^+
  Real stress_np1[dim + 1][stress_components<dim>]; ///< at t_{n+1}^-
};

/// Whether the advecting velocity is relative to the mesh. Leaving the mesh velocity out is wrong on a moving
/// mesh; the tests do it to show that they would notice.
enum class MeshVelocity { subtracted, left_out };

/// Nodal values at theta of the slab; x receives the corners.
template <MeshVelocity mesh_velocity, int dim, class Real>
inline void values_in_slab(const SpaceTimeValues<dim, Real>& in, double theta, double dt, bool with_stress,
                           Real x[dim + 1][dim], InstantValues<dim, Real>& v) noexcept {
  const double T0 = 1.0 - theta;
  const double T1 = theta;
  const double rate = 1.0 / dt;
  for (int a = 0; a <= dim; ++a) {
    v.p[a] = T0 * in.w[a][3] + T1 * in.w[a][7];
    if (with_stress)
      for (int i = 0; i < stress_components<dim>; ++i)
        v.stress[a][i] = T0 * in.stress_n[a][i] + T1 * in.stress_np1[a][i];
    for (int d = 0; d < dim; ++d) {
      x[a][d] = T0 * in.x_n[a][d] + T1 * in.x_np1[a][d];
      v.u[a][d] = T0 * in.w[a][d] + T1 * in.w[a][4 + d];
      v.c[a][d] = v.u[a][d];
      if constexpr (mesh_velocity == MeshVelocity::subtracted)
        v.c[a][d] -= rate * (in.x_np1[a][d] - in.x_n[a][d]);
      v.a[a][d] = rate * (in.w[a][4 + d] - in.w[a][d]) - (T0 * in.f_n[a][d] + T1 * in.f_np1[a][d]);
    }
  }
}

/// residual[a] = (R_(a,0)^u, R_(a,0)^p, R_(a,1)^u, R_(a,1)^p), and what its tangent needs.
template <int points = 2, MeshVelocity mesh_velocity = MeshVelocity::subtracted, int dim, class Real,
          class Rule>
inline void space_time_residual(const SpaceTimeValues<dim, Real>& in, const FlowParameters& parameters,
                                const Rule& rule, Real residual[dim + 1][8],
                                SlabInstants<dim, points, Real>& s) noexcept {
  constexpr int nodes = dim + 1;
  constexpr SlabRule<points> slab;
  const double dt = parameters.dt;
  s.jump = node_pair<dim> * simplex_geometry(in.x_n).volume;
  for (int a = 0; a < nodes; ++a)
    for (int i = 0; i < 8; ++i) residual[a][i] = Real{};
  for (int d = 0; d < dim; ++d) {
    Real jump[nodes];
    Real sum{};
    for (int a = 0; a < nodes; ++a) sum += jump[a] = in.w[a][d] - in.u_n[a][d];
    for (int a = 0; a < nodes; ++a) residual[a][d] = s.jump * (sum + jump[a]);
  }
  for (int point = 0; point < points; ++point) {
    const double theta = slab.theta[point];
    Real x[nodes][dim];
    InstantValues<dim, Real> v;
    values_in_slab<mesh_velocity>(in, theta, dt, parameters.viscous_residual, x, v);
    InstantResidual<dim, Real> at;
    evaluate_instant<dim>(x, v, slab.weight[point] * dt, rule, point, parameters.newton,
                          parameters.viscous_residual, s.point[point], at);
    const double T[2] = {1.0 - theta, theta};
    const double D[2] = {-1.0 / dt, 1.0 / dt};
    for (int a = 0; a < nodes; ++a)
      for (int al = 0; al < 2; ++al) {
        for (int d = 0; d < dim; ++d)
          residual[a][4 * al + d] += T[al] * at.momentum[a][d] + D[al] * at.time_test[a][d];
        residual[a][4 * al + 3] += T[al] * at.continuity[a];
      }
  }
}

} // namespace DROGUE_ISA
} // namespace drogue::fluid
