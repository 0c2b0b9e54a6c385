// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh_mover/extension.hpp"
#include "mesh_mover/stiffness.hpp"

namespace drogue::mesh_mover {

/// The pseudo-solid in equilibrium with its boundary's displacement: pseudo_solid.hpp.
class ElasticExtension : public Extension {
 public:
  /// @param share do this rank's share of the work; direct factors are not shared
  ElasticExtension(ExtensionInput input, bool share);

  [[nodiscard]] Result<void> prepare(std::span<const double> points) override;
  /// The residual is measured against the load of the increment.
  [[nodiscard]] Result<SolveOutcome> extend(std::span<double> u, std::span<const double> increment) override;

 private:
  [[nodiscard]] double free_norm(std::span<const double> f) const;

  ExtensionInput input_;
  PseudoSolid solid_;
  Stiffness stiffness_;
  LinearSolver solver_;
  std::vector<double> load_, work_;        // by nodes
  std::vector<double> load_rows_, u_rows_; // in the order of the matrix
};

} // namespace drogue::mesh_mover
