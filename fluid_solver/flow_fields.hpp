// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>
#include <vector>

#include "fluid_solver/fluid_mesh.hpp"
#include "fluid_solver/settings.hpp"

/// Quantities derived from a velocity and pressure field. x, u {n, 3} and p {n} in the solver's node order.
namespace drogue::fluid {

/// Constant in a linear element.
struct ElementState {
  double volume = 0;
  double grad_u[3][3] = {}; ///< du_i/dx_j
  double nu = 0;            ///< molecular + eddy kinematic viscosity
  double eddy = 0;          ///< eddy part alone
};
[[nodiscard]] ElementState element_state(const Settings& settings, const FluidMesh& mesh,
                                         std::span<const double> x, std::span<const double> u,
                                         std::int32_t cell);

/// Traction of the fluid on the wall behind a face, force per area [stress / density]: pressure part p n and
/// viscous part -2 nu S n, n out of the fluid; p the mean of the face.
struct FaceTraction {
  std::array<double, 3> pressure{};
  std::array<double, 3> viscous{};
  double area = 0;
};
[[nodiscard]] FaceTraction face_traction(const Settings& settings, const FluidMesh& mesh,
                                         std::span<const double> x, std::span<const double> u,
                                         std::span<const double> p, const BoundaryFace& face);

/// Nodal means of the elements' values, weighted by volume.
struct NodalFields {
  std::vector<double> vorticity; ///< {n, 3} [1/time]
  std::vector<double> q;         ///< {n} second invariant 1/2 (|Omega|^2 - |S|^2) [1/time^2]
  std::vector<double> eddy;      ///< {n} eddy kinematic viscosity
};
[[nodiscard]] NodalFields nodal_fields(const Settings& settings, const FluidMesh& mesh,
                                       std::span<const double> x, std::span<const double> u);

/// Largest |u| dt / h over the elements, h the edge of the regular tetrahedron (triangle) of equal volume.
[[nodiscard]] double largest_cfl(const FluidMesh& mesh, std::span<const double> x, std::span<const double> u,
                                 double dt);

/// Net volume flux out of the fluid over the gross flux through its boundary; u relative to the mesh
/// velocity.
[[nodiscard]] double mass_imbalance(const FluidMesh& mesh, std::span<const double> x,
                                    std::span<const double> u);

/// Nodal tractions on the wall {nodes.size(), 3} [stress / density]: exact pressures of the nodes, viscous
/// part and normals averaged by area over the faces of the given boundaries.
[[nodiscard]] std::vector<double> nodal_traction(const Settings& settings, const FluidMesh& mesh,
                                                 std::span<const double> x, std::span<const double> u,
                                                 std::span<const double> p,
                                                 std::span<const std::int32_t> boundaries,
                                                 std::span<const std::int32_t> nodes);

} // namespace drogue::fluid
