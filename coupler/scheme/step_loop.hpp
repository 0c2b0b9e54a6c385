// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "common/base/result.hpp"
#include "common/io/state_file.hpp"
#include "coupler/acceleration/accelerator.hpp"
#include "coupler/scheme/exchange.hpp"

namespace drogue::coupler {

/// Totals of a run, for the summary.
struct LoopTotals {
  int steps = 0;           ///< of the case
  int parts = 0;           ///< committed: as many as steps, or more when steps were done in halves
  int iterations = 0;      ///< all, those rolled back included
  int most_iterations = 0; ///< of a step, with all its parts and attempts
  int unconverged = 0;     ///< steps with a part that was accepted unconverged
  int retries = 0;
  int new_meshes = 0;                           ///< in the place of the fluid's mesh
  double used_columns = 0, dropped_columns = 0; ///< secants, summed over the iterations
  double added_mass_ratio =
      0; ///< ||dH|| / ||dd|| of the first secant: about the fluid's mass over the structure's
};

/// The nonlinear iteration of one time step [stein2001, "Fluid-Structure Coupling"]:
///   1 predict d, v
///   2 project to the fluid, move the mesh, solve the flow, project the load, solve the structure: d~ = H(d)
///   3 r = d~ - d; stop when ||r|| <= relative max(||d~ - d_n||, floor) or ||r|| <= absolute, and the
///   solvers' own
///     iterations have converged
///   4 accelerate v, to whose change the fluid's inertia answers; d by the same affine combination; go to 2.
///     The structure's own d~ and v~ lie on a line in every node, d~ = v~ dt / kappa + a constant of the
///     step, but the first iterate, which is extrapolated, does not: a residual of d would leave a wrong v in
///     the flow. Where the wall moves with d alone (MESH_RATE), and in relaxation, d and v change places.
/// In PARALLEL the structure takes in 2 the load f of the last iterate, and v and f are accelerated together.
/// In STRUCTURE_FIRST the load f is the unknown: the structure takes it, mesh and flow follow the structure's
/// answer, r = f~ - f as a load per area takes the place of d~ - d in 3, and 4 accelerates f.
/// A residual that stalls makes the accelerator start anew, and ends the iteration when it stalls again.
///   5 commit, or the policy for non-convergence
class StepLoop {
 public:
  [[nodiscard]] static Result<StepLoop> create(Participants& participants, Exchange& exchange,
                                               Results& results, const CaseSettings& settings);
  /// Does the step from `time` to `time + time_step` (in halves if the policy says so). False: a stop was
  /// asked for (coupler/stop.hpp), and all is as it was before the step; a step that cannot be taken back is
  /// finished.
  [[nodiscard]] Result<bool> advance(std::uint64_t step, double time, double time_step);
  /// Adds to a checkpoint what the steps to come depend on. @pre between two steps
  void save(io::State& state) const;
  /// Errors (ErrorKind::config): an array is missing, or does not fit.
  [[nodiscard]] Result<void> load(const io::State& state);
  [[nodiscard]] const LoopTotals& totals() const { return totals_; }
  void reset_totals() { totals_ = {}; }
  [[nodiscard]] const IterationRecord& last() const { return record_; }

 private:
  struct Level { ///< interface state at one time
    std::vector<double> d, v, f;
    double time_step = 0; ///< length of the step that led here
  };
  /// A step, or the part of one that is done in halves: fields are written at the end of whole steps.
  struct Part {
    int halvings = 0;
    bool is_last = true;
  };
  /// What the accelerator works on, and the field that follows it.
  struct Unknown {
    std::vector<double>&x, &h, &x_follower, &h_follower;
  };
  struct Outcome {
    bool converged = false;
    bool stopped = false;    ///< on request, before it converged
    bool acceptable = false; ///< not converged within the allowed iterations, but neither failed nor diverged
    int iterations = 0;
    std::string trouble; ///< why not, when a solver failed or the residual blew up
  };
  StepLoop(Participants& participants, Exchange& exchange, Results& results, const CaseSettings& settings)
      : participants_(participants), exchange_(exchange), results_(results), settings_(settings) {}

  [[nodiscard]] Result<bool> advance(std::uint64_t step, double time, double time_step, Part part);
  [[nodiscard]] Result<bool> take_back(const Station& at);
  [[nodiscard]] bool may_stop() const;
  [[nodiscard]] Result<Outcome> iterate(Station& at, double time, double time_step);
  [[nodiscard]] Result<void> finish(const Station& at, const Outcome& outcome, double time, double time_step,
                                    bool whole_step);
  [[nodiscard]] Result<void> use_step(double time_step);
  [[nodiscard]] Result<void> change_mesh(const Station& at, double time);
  [[nodiscard]] LoadShare load_share(double time) const;
  void predict(double time_step);
  void set_wall_velocity(double time_step);
  [[nodiscard]] Result<void> sweep(const Station& at, LoadShare share, double time_step);
  [[nodiscard]] double distance(std::span<const double> a, std::span<const double> b);
  void measure(double time_step);
  void learn_added_mass(int iteration);
  [[nodiscard]] bool is_small(double first_residual) const;
  [[nodiscard]] double density_norm(std::span<const double> force);
  [[nodiscard]] Unknown unknown();
  [[nodiscard]] bool weigh_load(const Unknown& u);
  [[nodiscard]] Result<void> next_of_both(const Unknown& u);
  [[nodiscard]] Result<void> next_load();
  [[nodiscard]] Result<void> next_iterate();

  Participants& participants_;
  Exchange& exchange_;
  Results& results_;
  const CaseSettings& settings_;
  /// Secants of the velocity belong to one length of the step: an accelerator for each, so that the return
  /// from halved steps finds the old ones again. Lengths differ by powers of two, exactly.
  std::map<double, std::unique_ptr<acceleration::Accelerator>> accelerators_;
  acceleration::Accelerator* accelerator_ = nullptr; ///< of the present length
  std::vector<double> weights_;                      ///< {3 n}: lumped area of each value

  Level n_, n_minus_1_, n_minus_2_;
  int known_levels_ = 1;
  bool step_unconverged_ = false;
  std::uint32_t attempt_ = 0; ///< of the present step: rises with every part and every retry
  std::vector<double> d_, v_, v_start_, d_tilde_, v_tilde_, work_;
  std::vector<double> x_before_, h_before_; ///< of the last iteration; PARALLEL: unknown and load
  std::vector<double> f_;                   ///< nodal forces: of the iterate; SERIAL: of the last iteration
  std::vector<double> mean_n_; ///< nodal forces as the fluid gave them, at the end of the last step
  double load_scale_ = 0; ///< PARALLEL: velocity (or length) per load, weighs v against f; 0: not known yet
  std::vector<double> x_,
      h_; ///< PARALLEL: v (or d) and scaled load densities; STRUCTURE_FIRST: load densities
  IterationRecord record_;
  LoopTotals totals_, totals_before_; ///< now, and before the present step
  std::uint64_t results_before_ = 0;  ///< length of coupling.csv before the present step
};

} // namespace drogue::coupler
