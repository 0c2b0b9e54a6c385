// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>

#include "mesh_mover/boundary_motion.hpp"
#include "mesh_mover/linear_solver.hpp"

namespace drogue::mesh_mover {

/// A way to carry the displacement of the boundary into the mesh.
class Extension {
 public:
  Extension() = default;
  Extension(const Extension&) = delete;
  Extension& operator=(const Extension&) = delete;
  virtual ~Extension() = default;

  /// Takes the mesh {nodes, 3} from which the next displacements are measured. @pre positive volumes
  [[nodiscard]] virtual Result<void> prepare(std::span<const double> points) = 0;

  /// Fills in the displacement of the mesh.
  /// @param u {nodes, 3}: the given entries hold the boundary's displacement, the others a start value; then
  /// all
  ///          hold the displacement
  /// @param increment {nodes, 3}: the part of the boundary's displacement that is new; only the given entries
  /// are
  ///          read. An iteration's accuracy is measured against it.
  /// Not converged is no error but says so in the outcome.
  [[nodiscard]] virtual Result<SolveOutcome> extend(std::span<double> u,
                                                    std::span<const double> increment) = 0;
};

/// The extension that the settings ask for. `cells` and `motion` must outlive it.
/// @param initial_jacobians {m}
[[nodiscard]] std::unique_ptr<Extension> make_extension(const Settings& settings, const Cells& cells,
                                                        const BoundaryMotion& motion,
                                                        std::span<const double> initial_jacobians);

} // namespace drogue::mesh_mover
