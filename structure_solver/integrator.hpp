// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "structure_solver/assembly.hpp"
#include "structure_solver/model.hpp"

namespace drogue::structure {

/// Everything that the next step depends on.
struct State {
  double time = 0;
  std::uint64_t step = 0;
  std::vector<double> u; ///< displacement from the reference configuration, {3 nodes} [length]
  std::vector<double> v; ///< velocity
  std::vector<double> a; ///< acceleration
  /// Nodal force of the fluid at `time`, {3 nodes} [force]; empty while there has been none.
  std::vector<double> interface_force;
};

/// The reference configuration at rest.
[[nodiscard]] State rest_state(const Model& model);

/// Coefficients of the generalised-alpha method [chung1993] from the spectral radius rho at infinite
/// frequency: alpha_m = (2 rho - 1)/(rho + 1), alpha_f = rho/(rho + 1), gamma = 1/2 - alpha_m + alpha_f, beta
/// = (1 - alpha_m + alpha_f)^2 / 4.
struct GeneralisedAlpha {
  double alpha_m, alpha_f, gamma, beta;
  [[nodiscard]] static GeneralisedAlpha from_rho(double rho) noexcept;
};

/// How a Newton iteration ended.
struct Outcome {
  bool converged = false;
  int iterations = 0;
  double residual = 0;   ///< relative to the first of the step
  double correction = 0; ///< largest nodal correction of the last iteration [length]
};

/// Forces and energies of a state.
struct Balance {
  double kinetic_energy = 0;
  double strain_energy = 0;
  /// |f_int - f_ext| over the free equations / |f_ext|: 0 in static equilibrium.
  double unbalance = 0;
  /// Sum of the reaction of each support, in the order of Model::supports [force].
  std::vector<std::array<double, 3>> reactions;
};

/// Generalised-alpha with Newton's method in each step.
///
/// Equation of motion at the intermediate time, with x_m = (1 - alpha) x_np1 + alpha x_n:
///   M a_m(alpha_m) + c M v_m(alpha_f) + f_int(u_m) - f_ext(u_m, p_m) - f_m = 0,
/// f_m = (1 - alpha_f) f_np1 + alpha_f f_n for the fluid's nodal force as for the loads of the config. While
/// there is no f_n (first step of a run) f_m = f_np1.
///
/// Newmark: u_np1 = u_n + dt v_n + dt^2 ((1/2 - beta) a_n + beta a_np1), v_np1 = v_n + dt ((1 - gamma) a_n +
/// gamma a_np1). Unknown: u_np1. The tangent is exact but for the load stiffness, which is kept only on
/// request. CHOLMOD factors it; when it is not positive definite UMFPACK does.
class Integrator {
 public:
  struct Options {
    double rho_infinity = 0.5;
    double mass_damping = 0; ///< c [1/time]
    NewtonSettings newton;
    int threads = 0; ///< of the assembly; 0: default_threads()
  };
  /// @pre `model` outlives the integrator
  Integrator(const Model& model, const Options& options, State start);

  [[nodiscard]] const State& committed() const { return n_; }
  [[nodiscard]] const State& trial() const { return np1_; }
  void reset(State state);
  /// Sets the clock of the committed state; the coupler's clock rules in a coupled run.
  void set_time(double time) { n_.time = time; }

  enum class Predictor { hold, extrapolate };
  /// Starts a step of length dt from the committed state: loads, held displacements, and the first iterate
  /// (u_n, or u_n + dt v_n). Depends on the committed state alone.
  void begin_step(double dt, Predictor predictor);
  /// f_np1 of the fluid, {3 nodes}.
  void set_interface_force(std::span<const double> force);
  /// Puts nodes where the coupler's iterate has them. `displacement` has shape {nodes, 3}.
  void set_displacement(std::span<const std::int32_t> nodes, std::span<const double> displacement);

  /// Iterates to the tolerance, at most newton.max_iterations times.
  /// Errors (numerical, retryable): the matrix is singular or a number is not finite.
  [[nodiscard]] Result<Outcome> iterate_to_tolerance();
  /// Does exactly `count` iterations.
  [[nodiscard]] Result<Outcome> iterate(int count);

  /// The trial state becomes the committed one.
  void commit();
  /// Drops the trial state.
  void rollback() { np1_ = n_; }

  /// The acceleration that balances the forces of the committed state on its free equations.
  void balance_start();
  /// @note evaluates the committed state at its own time
  [[nodiscard]] Balance balance();

  /// Residual of the step at the trial state, held equations zero, {3 nodes}; with its tangent when asked
  /// for.
  void residual(std::span<double> r, bool tangent);
  [[nodiscard]] const la::SparseMatrix& tangent() const { return assembler_.tangent(); }

 private:
  [[nodiscard]] Result<void> newton_iteration(Outcome& outcome);
  [[nodiscard]] Result<void> solve();
  void hold_supports(double time);
  void update_rates() noexcept;
  [[nodiscard]] bool small(const Outcome& outcome) const noexcept;

  const Model& model_;
  Options options_;
  GeneralisedAlpha alpha_;
  Assembler assembler_;
  la::CholeskySolver cholesky_;
  la::LuSolver lu_;
  State n_, np1_;
  double dt_ = 0;
  double first_residual_ = -1; // of the step; negative: none yet
  LoadValues loads_;           // at the intermediate time
  std::vector<double> u_m_, residual_, correction_;
};

} // namespace drogue::structure
