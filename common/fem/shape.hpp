// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "common/mesh/mesh.hpp"

namespace drogue::fem {

/// Largest number of nodes of a surface element.
inline constexpr int max_surface_nodes = 9;

/// Shape functions N_a and their derivatives with respect to the parent coordinates at one point.
/// Parent domains: triangle (0,0), (1,0), (0,1); quadrilateral [-1, 1]^2. Node order as in Gmsh.
struct SurfaceShape {
  int nodes = 0;
  std::array<double, max_surface_nodes> N{};
  std::array<double, max_surface_nodes> dN_dxi{};
  std::array<double, max_surface_nodes> dN_deta{};
};

/// @pre dimension(kind) == 2
[[nodiscard]] SurfaceShape surface_shape(mesh::ElementKind kind, double xi, double eta) noexcept;

/// True for quadrilaterals, false for triangles. @pre dimension(kind) == 2
[[nodiscard]] bool is_quadrilateral(mesh::ElementKind kind) noexcept;

/// Parent coordinates of the centre of the element.
[[nodiscard]] std::array<double, 2> parent_centre(mesh::ElementKind kind) noexcept;

} // namespace drogue::fem
