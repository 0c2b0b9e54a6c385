// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace drogue::fem {

/// A quadrature point on a surface element's parent domain; weights sum to the parent area (1/2 or 4).
struct SurfacePoint {
  double xi = 0;
  double eta = 0;
  double weight = 0;
};

/// A rule that integrates polynomials of total degree `degree` exactly on the parent domain of `kind` (on
/// quadrilaterals: of that degree in each coordinate). Interior points, positive weights. Triangles: 1, 3, 6
/// and 7 symmetric points up to degree 5, a collapsed Gauss product above. @pre 1 <= degree <= 20
[[nodiscard]] std::vector<SurfacePoint> surface_quadrature(mesh::ElementKind kind, int degree);

/// A quadrature point in a volume element's parent domain; weights sum to the parent volume (1/6 or 8).
struct VolumePoint {
  std::array<double, 3> xi{};
  double weight = 0;
};

/// As surface_quadrature, for volumes. Tetrahedra: 1, 4 and 14 symmetric points up to degree 5.
/// @pre 1 <= degree, and degree <= 5 on tetrahedra, 20 on hexahedra
[[nodiscard]] std::vector<VolumePoint> volume_quadrature(mesh::ElementKind kind, int degree);

/// Gauss-Legendre points and weights on [-1, 1], exact to degree 2 n - 1. @pre 1 <= n <= 32
struct GaussRule {
  std::vector<double> points;
  std::vector<double> weights;
};
[[nodiscard]] GaussRule gauss_legendre(int n);

} // namespace drogue::fem
