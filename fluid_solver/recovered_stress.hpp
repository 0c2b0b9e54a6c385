// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "common/la_krylov/node_graph.hpp"
#include "fluid_solver/fluid_mesh.hpp"

namespace drogue::fluid {

/// Viscous stress 2 nu S, constant in every linear element, as a continuous field: nodal means of the
/// elements, weighted by volume (the L2 projection with lumped mass). Its divergence inside an element is the
/// viscous part of the residual that linear shape functions cannot have [jansen1999]. Molecular viscosity
/// alone.
class RecoveredStress {
 public:
  /// For the elements that touch a rank's own nodes. `mesh` must outlive it.
  RecoveredStress(const FluidMesh& mesh, const la::RowRange& own);

  /// @param x       positions {n, 3}
  /// @param u       first component of the velocity of node i at u[stride i]
  /// @param nu      kinematic viscosity [length^2/time]
  /// @param stress  {n, 6}, in the order of stress_component(); valid at the nodes of the rank's elements
  void evaluate(std::span<const double> x, std::span<const double> u, std::size_t stride, double nu,
                std::vector<double>& stress);

 private:
  const FluidMesh& mesh_;
  std::vector<std::int32_t> cells_; ///< all that touch a node whose stress is needed
  std::vector<double> volume_;      ///< {n} sum over those
};

} // namespace drogue::fluid
