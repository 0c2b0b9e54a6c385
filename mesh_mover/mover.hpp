// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/io/state_file.hpp"
#include "mesh_mover/boundary_motion.hpp"
#include "mesh_mover/conjugate_gradient.hpp"
#include "mesh_mover/quality.hpp"

namespace drogue::mesh_mover {

/// What one call of MeshMover::solve did.
struct SolveReport {
  int iterations = 0;
  /// Euclidean norm of the residual, relative to the load of the boundary's increment in this step.
  double residual = 0;
  Quality quality;
};

/// Moves the fluid mesh: READY --begin_step--> IN_STEP --solve*--> IN_STEP --commit or rollback--> READY.
///
/// Within a step the matrix is fixed and only boundary values change: it is assembled and its preconditioner
/// factored in begin_step, and every solve starts from the last one of the same step. The first starts from
/// the displacement at t_n plus the last step's increment, in proportion of the steps. The solver corrects
/// the start value on its coarse space, which makes translations of the whole boundary exact to rounding.
/// What is computed depends on the committed state and the sequence of inputs alone.
class MeshMover {
 public:
  /// Errors (ErrorKind::config): an element without positive volume; a direction in which nothing holds the
  /// mesh.
  [[nodiscard]] static Result<std::unique_ptr<MeshMover>> create(mesh::Mesh mesh, const Settings& settings);

  /// Errors (ErrorKind::internal): the preconditioner cannot be set up.
  [[nodiscard]] Result<void> begin_step(double time_step);
  /// Finds the mesh for the boundary values of t_{n+1}.
  /// Errors (ErrorKind::numerical, retryable): not converged; an element inverted or below the smallest
  /// allowed volume. After an error displacement() is not valid; roll back. @pre in a step
  [[nodiscard]] Result<SolveReport> solve(const BoundaryInput& input);
  /// The last solve becomes the state at t_n. @pre the last solve succeeded
  void commit();
  /// Back to the state at begin_step.
  void rollback();

  /// Since the start, of the last solve (outside a step: at t_n), {nodes, 3} [length].
  [[nodiscard]] std::span<const double> displacement() const { return u_np1_; }
  /// Positions of the last solve, {nodes, 3} [length].
  [[nodiscard]] std::span<const double> points() const { return points_np1_; }
  [[nodiscard]] const mesh::Mesh& mesh() const { return mesh_; }
  [[nodiscard]] const BoundaryMotion& motion() const { return motion_; }
  /// Connectivity of all tetrahedra in mesh order {m, 4}.
  [[nodiscard]] std::span<const std::int32_t> tets() const { return tets_; }
  /// Of the mesh at t_n.
  [[nodiscard]] Quality current_quality() const;

  /// Adds the committed state to a checkpoint. @pre not in a step
  void save(io::State& state) const;
  /// Errors (ErrorKind::config): arrays missing or of a wrong size.
  [[nodiscard]] Result<void> load(const io::State& state);

 private:
  MeshMover(mesh::Mesh mesh, const Settings& settings, BoundaryMotion motion, std::vector<std::int32_t> tets,
            std::vector<double> jacobians);
  [[nodiscard]] Result<void> prepare(std::span<const double> points);
  void start_value();
  [[nodiscard]] double load_of_increment();
  [[nodiscard]] Result<SolveOutcome> relax(const BoundaryInput& input, double& reference);

  mesh::Mesh mesh_;
  Settings settings_;
  BoundaryMotion motion_;
  std::vector<std::int32_t> tets_;
  std::vector<double> initial_jacobians_;
  PseudoSolid solid_;
  Stiffness stiffness_;
  ConjugateGradient solver_;
  bool is_prepared_ = false;

  // Committed state.
  std::vector<double> u_n_;         // displacement since the start
  std::vector<double> increment_n_; // of the last step
  double time_step_n_ = 0;          // of the last step

  // State within the step.
  double time_step_ = 0;
  std::vector<double> u_np1_;
  std::vector<double> points_np1_;
  std::vector<double> w_; // unknown: the increment, or the displacement for Increment::from_initial
  std::vector<double> load_;
  std::vector<double> work_;
  std::vector<double> load_rows_, w_rows_; // load and unknown in the order of the matrix
};

} // namespace drogue::mesh_mover
