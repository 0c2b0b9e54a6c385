// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fluid_solver/kernel_isa.hpp"

namespace drogue::fluid {
inline namespace DROGUE_ISA {

/// A linear triangle (dim = 2) or tetrahedron (dim = 3) at one instant: the gradients of its shape functions
/// [1/length] and its volume, in two dimensions its area.
template <int dim, class Real>
struct SimplexGeometry {
  Real gradient[dim + 1][dim];
  Real volume;
};

/// Gradients and signed volume from the corners x[3][2]; positive when they run anticlockwise. A volume of
/// zero gives infinite gradients: check the mesh before.
template <class Real>
[[nodiscard]] inline SimplexGeometry<2, Real> simplex_geometry(const Real (*x)[2]) noexcept {
  SimplexGeometry<2, Real> geometry;
  auto& g = geometry.gradient;
  const Real e[2][2] = {{x[1][0] - x[0][0], x[1][1] - x[0][1]}, {x[2][0] - x[0][0], x[2][1] - x[0][1]}};
  const Real det = e[0][0] * e[1][1] - e[0][1] * e[1][0];
  const Real inverse = 1.0 / det;
  g[1][0] = e[1][1] * inverse;
  g[1][1] = -e[1][0] * inverse;
  g[2][0] = -e[0][1] * inverse;
  g[2][1] = e[0][0] * inverse;
  for (int d = 0; d < 2; ++d) g[0][d] = -(g[1][d] + g[2][d]);
  geometry.volume = 0.5 * det;
  return geometry;
}

/// The same from the corners x[4][3] of a tetrahedron; positive when corner 3 lies on the side of the normal
/// (x1 - x0) x (x2 - x0).
template <class Real>
[[nodiscard]] inline SimplexGeometry<3, Real> simplex_geometry(const Real (*x)[3]) noexcept {
  SimplexGeometry<3, Real> geometry;
  auto& g = geometry.gradient;
  Real e[3][3];
  for (int k = 0; k < 3; ++k)
    for (int d = 0; d < 3; ++d) e[k][d] = x[k + 1][d] - x[0][d];
  for (int k = 0; k < 3; ++k) { // cofactors: g_{k+1} = e_{k+1} x e_{k+2} / det
    const Real* a = e[(k + 1) % 3];
    const Real* b = e[(k + 2) % 3];
    for (int d = 0; d < 3; ++d) {
      const int i = (d + 1) % 3;
      const int j = (d + 2) % 3;
      g[k + 1][d] = a[i] * b[j] - a[j] * b[i];
    }
  }
  const Real det = e[0][0] * g[1][0] + e[0][1] * g[1][1] + e[0][2] * g[1][2];
  const Real inverse = 1.0 / det;
  for (int d = 0; d < 3; ++d) {
    for (int k = 1; k < 4; ++k) g[k][d] *= inverse;
    g[0][d] = -(g[1][d] + g[2][d] + g[3][d]);
  }
  geometry.volume = det * (1.0 / 6.0);
  return geometry;
}

} // namespace DROGUE_ISA
} // namespace drogue::fluid
