// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/io/state_file.hpp"
#include "mesh_mover/extension.hpp"
#include "mesh_mover/quality.hpp"

namespace drogue::mesh_mover {

/// Nodal field of a mesh that has taken the place of another one: the displacement of its nodes, at the
/// positions they have in the file, since the start of the run. What the boundaries do counts from that
/// start.
inline constexpr const char* start_displacement_name = "start_displacement";

/// What one call of MeshMover::solve did.
struct SolveReport {
  int iterations = 0;
  /// Euclidean norm of the residual, relative to the load of the boundary's increment in this step.
  double residual = 0;
  /// Parts into which the boundary's motion was cut.
  int sub_increments = 1;
  Quality quality;
  /// The limit of Settings::warn that the mesh breaks; empty: none.
  std::string warning;
};

/// Moves the fluid mesh: READY --begin_step--> IN_STEP --solve*--> IN_STEP --commit or rollback--> READY.
///
/// Within a step the mesh that carries the motion is fixed and only boundary values change: begin_step
/// prepares it, and every solve starts from the last one of the same step. The first starts from the
/// displacement at t_n plus the last step's increment, in proportion of the steps. Where the moved mesh
/// breaks a limit, the boundary's motion is cut into 2, 4, 8 ... equal sub-increments, each on the mesh of
/// the last one. What is computed depends on the committed state and the sequence of inputs alone.
class MeshMover {
 public:
  /// Errors (ErrorKind::config): an element without positive volume; a node without an element; a direction
  /// in which nothing holds the mesh.
  [[nodiscard]] static Result<std::unique_ptr<MeshMover>> create(mesh::Mesh mesh, const Settings& settings);

  /// Errors (ErrorKind::internal): the linear solver cannot be set up.
  [[nodiscard]] Result<void> begin_step(double time_step);
  /// Finds the mesh for the boundary values of t_{n+1}.
  /// Errors (ErrorKind::numerical, retryable): not converged; an element inverted or a limit of
  /// Settings::stop broken, with as many sub-increments as are allowed. After an error displacement() is not
  /// valid; roll back.
  /// @pre in a step
  [[nodiscard]] Result<SolveReport> solve(const BoundaryInput& input);
  /// The last solve becomes the state at t_n. @pre the last solve succeeded
  void commit();
  /// Back to the state at begin_step.
  void rollback();

  /// Since the positions in the mesh file, of the last solve (outside a step: at t_n), {nodes, 3} [length].
  [[nodiscard]] std::span<const double> displacement() const { return u_np1_; }
  /// Positions of the last solve, {nodes, 3} [length].
  [[nodiscard]] std::span<const double> points() const { return points_np1_; }
  /// Since the start of the run; another one than displacement() when the mesh is a replacement.
  [[nodiscard]] std::vector<double> displacement_since_start() const;
  /// The mesh has taken the place of another one.
  [[nodiscard]] bool is_replacement() const { return !base_.empty(); }
  [[nodiscard]] const mesh::Mesh& mesh() const { return mesh_; }
  [[nodiscard]] const BoundaryMotion& motion() const { return motion_; }
  [[nodiscard]] const Cells& cells() const { return cells_; }
  [[nodiscard]] const InitialShapes& initial_shapes() const { return initial_; }
  /// Of the mesh at t_n.
  [[nodiscard]] Quality current_quality() const;

  /// Adds the committed state to a checkpoint. @pre not in a step
  void save(io::State& state) const;
  /// Errors (ErrorKind::config): arrays missing or of a wrong size.
  [[nodiscard]] Result<void> load(const io::State& state);

 private:
  MeshMover(mesh::Mesh mesh, const Settings& settings, Cells cells, BoundaryMotion motion,
            InitialShapes initial);
  template <class Function>
  void for_each_given(Function&& function) const;
  [[nodiscard]] bool from_initial() const { return settings_.increment == Increment::from_initial; }
  [[nodiscard]] Result<void> prepare_base();
  void start_value();
  void set_target(const BoundaryInput& input);
  [[nodiscard]] Result<SolveReport> move_at_once();
  [[nodiscard]] Result<SolveReport> move_in(int parts);
  [[nodiscard]] Result<SolveReport> judge(SolveReport report) const;
  void set_displacement(std::size_t i, double u);

  mesh::Mesh mesh_;
  Settings settings_;
  Cells cells_;
  BoundaryMotion motion_;
  InitialShapes initial_;
  std::unique_ptr<Extension> extension_;
  bool is_prepared_ = false; // for the mesh at t_n, or the initial one for Increment::from_initial

  // Of a replacement, else empty.
  std::vector<double> base_;   ///< displacement since the start of the run, in the mesh file's positions
  std::vector<double> origin_; ///< positions at the start of the run

  // Committed state.
  std::vector<double> u_n_;         // displacement since the file's positions
  std::vector<double> increment_n_; // of the last step
  double time_step_n_ = 0;          // of the last step

  // State within the step.
  double time_step_ = 0;
  int parts_ = 1; // sub-increments that the last solve needed
  std::vector<double> u_np1_;
  std::vector<double> points_np1_;
  std::vector<double> target_;    // given entries: the boundary's displacement
  std::vector<double> w_;         // unknown: the increment, or the displacement for Increment::from_initial
  std::vector<double> increment_; // given entries: what is new
};

} // namespace drogue::mesh_mover
