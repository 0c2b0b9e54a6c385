// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "structure_solver/assembly.hpp"
#include "structure_solver/model.hpp"
#include "structure_solver/supports.hpp"

namespace drogue::structure {

/// Energy that went in and out since the start of a run [force length]. The work of a step is that of the
/// forces at the intermediate time on the displacement of the step.
struct EnergyLedger {
  std::optional<double> start; ///< kinetic and strain energy before the first step
  double external = 0;         ///< work of the loads, of the fluid and of drag
  double support = 0;          ///< work of the reactions where supports move
  double actuator = 0;         ///< work of changing natural lengths
  double damping = 0;          ///< dissipated by mass- and stiffness-proportional damping
};

/// Everything that the next step depends on.
struct State {
  double time = 0;
  std::uint64_t step = 0;
  std::vector<double> u; ///< displacement from the reference configuration, {3 nodes} [length]
  std::vector<double> v; ///< velocity
  std::vector<double> a; ///< acceleration
  /// Nodal force of the fluid at `time`, {3 nodes} [force]; empty while there has been none.
  std::vector<double> interface_force;
  EnergyLedger ledger;
  /// How many times the step of a run is halved at present.
  int halvings = 0;
};

/// The reference configuration at rest.
[[nodiscard]] State rest_state(const Model& model);

/// Coefficients of the generalised-alpha family: inertia at (1 - alpha_m) t_np1 + alpha_m t_n, everything
/// else at (1 - alpha_f) t_np1 + alpha_f t_n.
struct GeneralisedAlpha {
  double alpha_m = 0, alpha_f = 0, gamma = 0.5, beta = 0.25;

  /// [chung1993] from the spectral radius rho at infinite frequency: alpha_m = (2 rho - 1)/(rho + 1), alpha_f
  /// = rho/(rho + 1), gamma = 1/2 - alpha_m + alpha_f, beta = (1 - alpha_m + alpha_f)^2 / 4.
  GeneralisedAlpha(double rho_infinity) noexcept;
  [[nodiscard]] static GeneralisedAlpha from_rho(double rho) noexcept { return {rho}; }
  /// [hilber1977], alpha in [-1/3, 0]: alpha_m = 0, alpha_f = -alpha, gamma = 1/2 - alpha, beta = (1 -
  /// alpha)^2 / 4.
  [[nodiscard]] static GeneralisedAlpha hht(double alpha) noexcept;
  /// [newmark1959]: alpha_m = alpha_f = 0.
  [[nodiscard]] static GeneralisedAlpha newmark(double beta, double gamma) noexcept;
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
  EnergyLedger ledger;
  /// What is missing of the energy: put in and neither stored nor dissipated by damping. Positive: the time
  /// integration dissipates.
  double energy_lost = 0;
  /// |f_int - f_ext| over the free equations / |f_ext|: 0 in static equilibrium.
  double unbalance = 0;
  /// Sum of the reaction of each support, in the order of Model::supports [force].
  std::vector<std::array<double, 3>> reactions;
  /// Sum of all loads but the interface's, weight and drag of bodies that are not meshed among them [force].
  std::array<double, 3> external_force{};
  /// Sum of the interface's loads [force].
  std::array<double, 3> interface_force{};
};

/// Generalised-alpha with Newton's method in each step.
///
/// Equation of motion at the intermediate time, with x_m = (1 - alpha) x_np1 + alpha x_n:
///   M a_m(alpha_m) + c M v_m(alpha_f) + f_int(u_m) - f_ext(u_m, p_m) - f_m = 0,
/// f_m = (1 - alpha_f) f_np1 + alpha_f f_n for the fluid's nodal force as for the loads of the config. While
/// there is no f_n (first step of a run) f_m = f_np1.
///
/// Drag acts with u_m, v_m and the air at t_m. Stiffness-proportional damping, time tau: f_int(u_m + tau v_m)
/// replaces f_int(u_m); for small tau v_m that adds tau K v_m, and the tangent stays exact and symmetric.
///
/// Held equations follow the expressions of their supports, velocity and acceleration their derivatives.
///
/// Statics: the same without inertia, damping and velocities, at t_np1; with a ramp the loads grow in
/// proportion to time.
///
/// Newmark: u_np1 = u_n + dt v_n + dt^2 ((1/2 - beta) a_n + beta a_np1), v_np1 = v_n + dt ((1 - gamma) a_n +
/// gamma a_np1). Unknown: u_np1. The tangent is exact but for the load stiffness, which is kept only on
/// request. CHOLMOD factors it; when it is not positive definite UMFPACK does.
class Integrator {
 public:
  struct Options {
    GeneralisedAlpha scheme = 0.5;
    double mass_damping = 0; ///< c [1/time]
    NewtonSettings newton;
    int threads = 0;              ///< of the assembly; 0: default_threads()
    double stiffness_damping = 0; ///< tau [time]
    bool statics = false;
    struct Ramp {
      double begin, end;
    };
    /// The loads grow from nothing at `begin` to their full size at `end`.
    std::optional<Ramp> ramp = std::nullopt;
  };
  /// @pre `model` outlives the integrator
  Integrator(const Model& model, const Options& options, State start);

  [[nodiscard]] const State& committed() const { return n_; }
  [[nodiscard]] const State& trial() const { return np1_; }
  void reset(State state);
  /// Sets the clock of the committed state; the coupler's clock rules in a coupled run.
  void set_time(double time) { n_.time = time; }
  void set_step(std::uint64_t step) { n_.step = step; }
  void set_halvings(int halvings) { n_.halvings = halvings; }

  enum class Predictor { hold, extrapolate };
  /// Starts a step of length dt from the committed state: loads, held displacements, and the first iterate
  /// (u_n, or u_n + dt v_n). Depends on the committed state alone. A load without a value fails the
  /// iteration.
  /// @param completes  false: a part of a step, which does not count
  void begin_step(double dt, Predictor predictor, bool completes = true);
  /// f_np1 of the fluid, {3 nodes}.
  void set_interface_force(std::span<const double> force);
  /// Puts nodes where the coupler's iterate has them. `displacement` has shape {nodes, 3}.
  void set_displacement(std::span<const std::int32_t> nodes, std::span<const double> displacement);

  /// Iterates to the tolerance, at most newton.max_iterations times.
  /// Errors (numerical, retryable): the matrix is singular or a number is not finite.
  [[nodiscard]] Result<Outcome> iterate_to_tolerance();
  /// Does exactly `count` iterations.
  [[nodiscard]] Result<Outcome> iterate(int count);

  /// The trial state becomes the committed one; its energies are accounted for.
  void commit();
  /// Drops the trial state.
  void rollback() { np1_ = n_; }

  /// The acceleration that balances the forces of the committed state on its free equations.
  void balance_start();
  /// @note evaluates the committed state at its own time
  [[nodiscard]] Balance balance();

  /// The nodes with the largest residuals of the last iteration, in words.
  [[nodiscard]] std::string worst_nodes() const;
  /// Statics: looks for a motion that no stiffness resists at the committed state.
  /// Errors (config): there is one; with the node that moves most.
  [[nodiscard]] Result<void> check_mechanism();

  /// Residual of the step at the trial state, held equations zero, {3 nodes}; with its tangent when asked
  /// for.
  void residual(std::span<double> r, bool tangent);
  [[nodiscard]] const la::SparseMatrix& tangent() const { return assembler_.tangent(); }

 private:
  [[nodiscard]] Result<void> newton_iteration(Outcome& outcome);
  [[nodiscard]] Result<void> solve();
  void apply_held() noexcept;
  void update_rates() noexcept;
  [[nodiscard]] bool small(const Outcome& outcome) const noexcept;
  [[nodiscard]] double load_factor(double time) const noexcept;
  [[nodiscard]] Error not_finite(const char* what) const;
  /// The fluid's force at the intermediate time in equation i.
  [[nodiscard]] double interface_force(std::size_t i, double alpha_f) const noexcept;
  /// Equation of motion with held equations as they are: their reactions.
  void full_residual(const LoadValues& loads, double alpha_f, std::span<double> r, bool tangent);
  [[nodiscard]] double kinetic_energy(const State& state) const noexcept;
  /// Forces of the committed state: residual_ = f_int(u) - f_ext; returns the stored energy.
  double static_residual(const LoadValues& loads, std::span<const double> u);
  std::array<double, 3> external_force(const LoadValues& loads);
  void account_for_step();
  [[nodiscard]] double work_of_damping(const LoadValues& loads);
  [[nodiscard]] double work_of_lengths() const;

  const Model& model_;
  Options options_;
  GeneralisedAlpha alpha_;
  Assembler assembler_;
  la::CholeskySolver cholesky_;
  la::LuSolver lu_;
  State n_, np1_;
  double dt_ = 0;
  double first_residual_ = -1; // of the step; negative: none yet
  std::optional<Error> step_error_;
  std::vector<HeldMotion> held_;           // at t_np1
  LoadValues loads_n_, loads_np1_, loads_; // the last at the intermediate time
  std::vector<double> u_m_, v_m_, u_damped_, residual_, correction_;
};

} // namespace drogue::structure
