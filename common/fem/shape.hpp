// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "common/mesh/mesh.hpp"

namespace drogue::fem {

using mesh::ElementKind;

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
[[nodiscard]] SurfaceShape surface_shape(ElementKind kind, double xi, double eta) noexcept;

/// The same on edges; parent domain [-1, 1], node order: ends, then the middle.
struct LineShape {
  int nodes = 0;
  std::array<double, 3> N{};
  std::array<double, 3> dN_dxi{};
};

/// @pre dimension(kind) == 1
[[nodiscard]] LineShape line_shape(ElementKind kind, double xi) noexcept;

/// Largest number of nodes of a volume element.
inline constexpr int max_volume_nodes = 27;

/// The same in volumes. Parent domains: tetrahedron (0,0,0), (1,0,0), (0,1,0), (0,0,1); hexahedron [-1, 1]^3.
struct VolumeShape {
  int nodes = 0;
  std::array<double, max_volume_nodes> N{};
  /// Rows: derivatives with respect to xi, eta, zeta.
  std::array<std::array<double, max_volume_nodes>, 3> dN{};
};

/// @pre dimension(kind) == 3
[[nodiscard]] VolumeShape volume_shape(ElementKind kind, const std::array<double, 3>& xi) noexcept;

/// Parent coordinates of node `a` of a volume element. @pre dimension(kind) == 3
[[nodiscard]] std::array<double, 3> volume_node(ElementKind kind, int a) noexcept;

/// True for quadrilaterals, false for triangles. @pre dimension(kind) == 2
[[nodiscard]] bool is_quadrilateral(ElementKind kind) noexcept;

/// Parent coordinates of the centre of the element.
[[nodiscard]] std::array<double, 2> parent_centre(ElementKind kind) noexcept;

} // namespace drogue::fem
