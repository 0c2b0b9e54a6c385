// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/base/result.hpp"
#include "fluid_solver/boundary_conditions.hpp"
#include "fluid_solver/flow_state.hpp"
#include "fluid_solver/flow_system.hpp"
#include "fluid_solver/recovered_stress.hpp"
#include "fluid_solver/settings.hpp"
#include "fluid_solver/step_data.hpp"

namespace drogue::fluid {

/// How a step is taken. Semi-discrete of order 2 takes the first step, and any whose forerunner is not known,
/// with order 1.
struct StepScheme {
  Formulation formulation = Formulation::dsd_sst;
  int time_order = 1;     ///< of semi_discrete
  int time_points = 2;    ///< quadrature points of dsd_sst in time
  bool convection = true; ///< of semi_discrete
};

/// Newton iterations of one call, or summed over a step.
struct NewtonReport {
  int iterations = 0;
  int linear_iterations = 0;
  double residual = 0; ///< last evaluated, relative to the first of the step
  double worst = 0;    ///< largest so far in the step, relative to the first
  bool converged = false;
  bool linear_converged = true;
};

/// Steps the flow. The same object and calls on every rank; every function that returns a Result is
/// collective.
///
///   begin_step -> (set_end -> newton)* -> finish -> commit, or rollback at any point after begin_step.
///
/// Deterministic: what a step computes depends on the committed state and on the calls since begin_step only.
/// Jacobian, factorisation and scaling are rebuilt in every step.
class FlowSolver {
 public:
  /// Starts from the settings' initial fields. `settings` and `mesh` must outlive the solver.
  FlowSolver(const Settings& settings, const FluidMesh& mesh);

  [[nodiscard]] const FlowState& state() const { return state_; }
  /// The committed state for a file, pressure physical, node order of the mesh file.
  [[nodiscard]] io::State export_state() const;
  /// Errors (ErrorKind::config): other kind, other mesh, an array missing or of the wrong size.
  [[nodiscard]] Result<void> import_state(const io::State& file);

  /// Goes on from a state. @pre its arrays fit the mesh
  void set_state(FlowState state) { state_ = std::move(state); }
  /// Time and number of the committed state, where another clock than the state file's counts.
  void set_clock(double time, std::uint64_t step) {
    state_.time = time;
    state_.step = step;
  }

  /// Projects the committed velocity on fields without divergence (in the stabilised equations) that meet the
  /// boundary conditions at its time: a step too short for anything but the pressure to act. The pressure
  /// stays.
  [[nodiscard]] Result<void> project_velocity();
  /// Velocity and pressure after some DSD/SST slabs of length dt on the mesh at rest, the walls keeping their
  /// velocity; time, step and mesh stay. For a flow that was carried over from another mesh: see
  /// docs/theory.md, "A new mesh". Errors (ErrorKind::numerical): a slab does not converge.
  [[nodiscard]] Result<void> settle(double dt, int time_points, int slabs);
  [[nodiscard]] Result<void> begin_step(const StepScheme& scheme, double dt);
  /// Mesh at t_{n+1}; wall velocities at t_n^+ and t_{n+1}^-; all {n, 3}, read at walls. Not called:
  /// mesh and walls stay at rest. Errors (retryable): an inverted element.
  [[nodiscard]] Result<void> set_end(std::span<const double> x_np1, std::span<const double> wall_n,
                                     std::span<const double> wall_np1);
  /// At most `iterations` Newton iterations; stops early at the settings' residual tolerance or, with `all`,
  /// at rounding alone.
  [[nodiscard]] Result<NewtonReport> newton(int iterations, bool all = false);
  /// Evaluates the residual at the last iterate: reactions, and the step's final figures.
  [[nodiscard]] Result<NewtonReport> finish();
  void commit();
  void rollback() {}

  /// End-of-step values of the current iterate.
  [[nodiscard]] std::vector<double> velocity_np1() const;
  [[nodiscard]] std::vector<double> pressure_np1() const;  ///< kinematic
  [[nodiscard]] std::vector<double> pressure_mean() const; ///< kinematic, mean of the step
  /// @pre begin_step was called
  [[nodiscard]] const StepData& step_data() const { return data_; }
  /// @pre finish was called in this step
  [[nodiscard]] const FlowSystem& system() const { return *active_; }

 private:
  [[nodiscard]] Result<double> evaluate(bool jacobian);
  void apply_constraints();
  void recover_stress();
  void set_scale();
  [[nodiscard]] Result<la::Outcome> correct(double residual);
  void set_time_difference(int order);

  const Settings& settings_;
  const FluidMesh& mesh_;
  VelocityConstraints constraints_;
  std::unique_ptr<FlowSystem> systems_[2];
  FlowSystem* active_ = nullptr;
  std::optional<RecoveredStress> recovered_; ///< where the settings ask for it
  FlowState state_;
  StepData data_;
  NewtonReport total_;
  std::optional<double> first_residual_;
  double residual_floor_ = 0;
  bool convection_ = true;
  std::vector<double> before_;      ///< unknowns before a correction
  int updates_since_jacobian_ = -1; ///< -1: no Jacobian in this step yet
};

} // namespace drogue::fluid
