// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>

#include "mesh_mover/boundary_motion.hpp"
#include "mesh_mover/linear_solver.hpp"

namespace drogue::mesh_mover {

/// What an extension is made of; the same on every rank.
struct ExtensionInput {
  Method method = Method::elastic;
  Cells cells;
  Mask given;
  /// Method::elastic: factors of the elements' stiffness {m}, empty: one.
  std::vector<double> factors;
  /// Method::algebraic: the nodes that each displaced boundary governs alone.
  std::vector<std::vector<std::int32_t>> bodies;
  struct Numbers {
    double poisson_ratio = 0;
    double stiffening_exponent = 0;
    double mean_jacobian = 0;
    double tolerance = 0;
    double weight_exponent = 0;
    int max_iterations = 0;
    LinearSolverKind linear_solver = LinearSolverKind::automatic;
  } numbers;
};

/// A way to carry the displacement of the boundary into the mesh. On several ranks every function is called
/// on each of them with the same arguments and gives the same results.
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

/// @param initial_jacobians {m}
[[nodiscard]] ExtensionInput extension_input(const Settings& settings, const Cells& cells,
                                             const BoundaryMotion& motion,
                                             std::span<const double> initial_jacobians);

/// The extension on this process, or its share of it among all ranks.
/// @param share false: this process works alone
[[nodiscard]] std::unique_ptr<Extension> make_extension(ExtensionInput input, bool share);

/// The extension that the settings ask for. On several ranks it is to be made and used on the first one
/// alone: the others do their share in serve_extensions() (shared_extension.hpp).
/// @param initial_jacobians {m}
[[nodiscard]] std::unique_ptr<Extension> make_extension(const Settings& settings, const Cells& cells,
                                                        const BoundaryMotion& motion,
                                                        std::span<const double> initial_jacobians);

} // namespace drogue::mesh_mover
