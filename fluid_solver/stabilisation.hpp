// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fluid_solver/batch.hpp"
#include "fluid_solver/flow_parameters.hpp"
#include "fluid_solver/simplex_geometry.hpp"

namespace drogue::fluid {
inline namespace DROGUE_ISA {

/// Element coefficients at one instant. The tangent holds them constant.
template <class Real>
struct Coefficients {
  Real nu;       ///< molecular + eddy viscosity [length^2/time]
  Real tau;      ///< tau_supg = tau_pspg [time]
  Real tau_lsic; ///< [length^2/time]
  Real tau_time; ///< tau_supg of the test functions' time derivative [time]
};

/// Edge of the regular triangle or tetrahedron of the same volume [length].
template <int dim, class Real>
[[nodiscard]] inline Real element_length(Real volume) noexcept {
  if constexpr (dim == 2)
    return square_root(4.0 / 1.7320508075688772 * volume);
  else
    return cube_root(6.0 * 1.4142135623730951 * volume);
}

/// Smagorinsky's eddy viscosity (Cs h)^2 sqrt(2 S:S), S the symmetric velocity gradient [length^2/time].
/// grad_u[i][j] = du_i/dx_j.
template <int dim, class Real>
[[nodiscard]] inline Real eddy_viscosity(Real h, const Real (*grad_u)[dim], double cs) noexcept {
  Real twice_s_s{};
  for (int i = 0; i < dim; ++i)
    for (int j = 0; j < dim; ++j) {
      const Real twice_s = grad_u[i][j] + grad_u[j][i];
      twice_s_s += 0.5 * twice_s * twice_s;
    }
  const Real length = cs * h;
  return length * length * square_root(twice_s_s);
}

/// Stabilisation parameters after [tezduyar2003], UGN form, with c the advecting velocity (relative to the
/// mesh) at the centroid:
///   tau      = ((sum_a |c . grad N_a|)^2 + (2/dt)^2 + (4 nu / h^2)^2)^(-1/2)
///   h_ugn    = 2 |c| / sum_a |c . grad N_a|
///   tau_lsic = 1/2 h_ugn |c| min(1, Re/3),   Re = |c| h_ugn / (2 nu)
/// Limits: tau -> dt/2 for small dt, h^2 / (4 nu) when diffusion dominates; tau_lsic -> 0 in a fluid at rest.
struct StandardCoefficients {
  FlowParameters parameters;

  template <int dim, class Real>
  [[nodiscard]] Coefficients<Real> operator()(int /*instant*/, const SimplexGeometry<dim, Real>& geometry,
                                              const Real* c, const Real (*grad_u)[dim]) const noexcept {
    constexpr double tiny = 1e-300;
    const Real h = element_length<dim>(geometry.volume);
    Coefficients<Real> k;
    k.nu = parameters.nu + eddy_viscosity<dim>(h, grad_u, parameters.smagorinsky);
    Real speed_squared{};
    for (int d = 0; d < dim; ++d) speed_squared += c[d] * c[d];
    const Real speed = square_root(speed_squared);
    Real advection{};
    for (const auto& g : geometry.gradient) {
      Real c_g = c[0] * g[0];
      for (int d = 1; d < dim; ++d) c_g += c[d] * g[d];
      advection += absolute(c_g);
    }
    const double rate = 2.0 / parameters.tau_dt;
    const Real diffusion = 4.0 * k.nu / (h * h);
    k.tau = 1.0 / square_root(advection * advection + rate * rate + diffusion * diffusion);
    k.tau_time = parameters.time_weight ? k.tau : Real{};
    const Real h_ugn = 2.0 * speed / (advection + tiny);
    const Real speed_h = speed * h_ugn;
    // min(1, Re/3) = |c| h / max(|c| h, 6 nu)
    k.tau_lsic = parameters.lsic ? 0.5 * speed_h * (speed_h / (larger(speed_h, 6.0 * k.nu) + tiny)) : Real{};
    return k;
  }
};

} // namespace DROGUE_ISA
} // namespace drogue::fluid
