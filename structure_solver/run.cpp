// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/run.hpp"

#include <algorithm>

#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "structure_solver/progress.hpp"
#include "structure_solver/results.hpp"
#include "structure_solver/state_io.hpp"

namespace drogue::structure {
namespace {

/// The step of damped dynamics: grows after easy steps, shrinks after hard or failed ones.
constexpr double growth = 1.25, hard_shrink = 0.7, failed_shrink = 0.5;
constexpr int easy_iterations = 5, hard_iterations = 8;
/// The smallest step, relative to the first.
constexpr double smallest_step = 1e-5;
/// Where a run that failed leaves its last good state.
constexpr const char* last_good_state = "last_good.state";

const char* name(TimeMode mode) {
  switch (mode) {
  case TimeMode::dynamic:
    return "dynamics";
  case TimeMode::static_by_damped_dynamics:
    return "damped dynamics";
  case TimeMode::static_by_newton:
    break;
  }
  return "statics";
}

class Run {
 public:
  explicit Run(const Case& c)
      : case_(c),
        integrator_(*c.model, c.integrator_options(), c.start),
        results_(c.settings, *c.model, c.settings.output.directory) {}

  Result<void> operator()() {
    const TimeSettings& time = case_.settings.time;
    const bool damped = time.mode == TimeMode::static_by_damped_dynamics;
    if (time.mode == TimeMode::static_by_newton) DROGUE_TRY(integrator_.check_mechanism());
    if (time.balanced_start && time.mode != TimeMode::static_by_newton) integrator_.balance_start();
    spdlog::info("{} nodes, {} equations, {} to t = {}", case_.model->node_count(),
                 case_.model->equation_count(), name(time.mode),
                 case_.start.time + (damped ? time.largest_time : time.steps * time.step));
    Result<void> outcome = damped ? static_equilibrium() : whole_steps();
    progress_.finish();
    // What was reached is kept, whatever ended the run.
    DROGUE_TRY(results_.fields(integrator_.committed()));
    const bool stopped = !outcome && outcome.error().kind == ErrorKind::interrupted;
    if (case_.settings.final_state && (outcome || stopped))
      DROGUE_TRY(save_state(*case_.settings.final_state, *case_.model, integrator_.committed()));
    if (!outcome && !stopped) return with_last_good_state(outcome.error());
    if (outcome)
      spdlog::info("done: {} steps, {} Newton iterations, {} rejected steps, {:.2f} s", steps_, iterations_,
                   rejected_, progress_.seconds());
    return outcome;
  }

 private:
  /// Dynamics, and statics by Newton's method.
  Result<void> whole_steps() {
    const TimeSettings& time = case_.settings.time;
    for (int k = 0; k < time.steps; ++k) {
      const auto outcome = whole_step();
      if (!outcome) return outcome.error();
      DROGUE_TRY(report(*outcome, case_.start.step + static_cast<std::uint64_t>(time.steps)));
      if (interrupted()) return stopped();
    }
    return {};
  }

  /// One step of the config, in parts where Newton's method needs them. The whole is 2^max_halvings units
  /// long; a part starts at a multiple of its length, and grows back after an easy one.
  Result<Outcome> whole_step() {
    const TimeSettings& time = case_.settings.time;
    const std::uint64_t whole = std::uint64_t{1} << time.max_halvings;
    const auto predictor =
        time.mode == TimeMode::dynamic ? Integrator::Predictor::extrapolate : Integrator::Predictor::hold;
    int halvings = std::min(integrator_.committed().halvings, time.max_halvings);
    Outcome sum;
    for (std::uint64_t at = 0; at < whole;) {
      const std::uint64_t part = whole >> halvings;
      const double dt = time.step * (static_cast<double>(part) / static_cast<double>(whole));
      const auto outcome = attempt(dt, predictor, at + part == whole);
      if (!outcome && !outcome.error().retryable) return outcome.error();
      if (!outcome || !outcome->converged) {
        const Error failed = outcome ? not_converged(*outcome) : outcome.error();
        integrator_.rollback();
        ++rejected_;
        if (halvings == time.max_halvings) return failed;
        ++halvings;
        continue;
      }
      integrator_.commit();
      at += part;
      sum.iterations += outcome->iterations;
      sum.converged = true;
      const bool easy = outcome->iterations <= easy_iterations;
      if (easy && halvings > 0 && at % (2 * part) == 0) --halvings;
      integrator_.set_halvings(halvings);
    }
    return sum;
  }

  [[nodiscard]] Error not_converged(const Outcome& outcome) const {
    return numerical_error(
        "Newton did not converge in the step to t = {}: after {} iterations the correction is {:.3g} and the "
        "residual "
        "{:.3g} of the step's first; a smaller time.step or more time.max_halvings may help{}",
        integrator_.trial().time, outcome.iterations, outcome.correction, outcome.residual,
        integrator_.worst_nodes());
  }

  /// Keeps the last committed state beside the results, and says so.
  Error with_last_good_state(Error error) {
    const auto file = case_.settings.output.directory / last_good_state;
    std::error_code ignored;
    std::filesystem::create_directories(case_.settings.output.directory, ignored);
    const auto saved = save_state(file, *case_.model, integrator_.committed());
    error.message +=
        saved ? fmt::format("\nthe last good state, t = {}, is in {}", integrator_.committed().time,
                            file.string())
              : fmt::format("\nand its last good state could not be kept: {}", saved.error().message);
    return error;
  }

  Result<void> static_equilibrium() {
    const TimeSettings& time = case_.settings.time;
    const double end = case_.start.time + time.largest_time;
    double dt = time.step;
    while (integrator_.committed().time < end) {
      const auto outcome = attempt(dt, Integrator::Predictor::hold, true);
      if (!outcome && !outcome.error().retryable) return outcome.error();
      if (!outcome || !outcome->converged) {
        const std::string worst = integrator_.worst_nodes();
        integrator_.rollback();
        ++rejected_;
        dt *= failed_shrink;
        if (dt < smallest_step * time.step)
          return numerical_error("no static equilibrium: Newton fails at t = {} even with a step of {:.3g}{}",
                                 integrator_.committed().time, dt, worst);
        continue;
      }
      integrator_.commit();
      DROGUE_TRY(report(*outcome, 0));
      if (unbalance_ < time.unbalance) return {};
      if (interrupted()) return stopped();
      if (outcome->iterations <= easy_iterations) dt = std::min(time.largest_step, growth * dt);
      if (outcome->iterations > hard_iterations) dt *= hard_shrink;
    }
    return numerical_error(
        "no static equilibrium within time.largest_time = {}: the unbalance is {:.3g}, not below {:.3g}; "
        "more mass_damping or a longer time may help",
        time.largest_time, unbalance_, time.unbalance);
  }

  Result<Outcome> attempt(double dt, Integrator::Predictor predictor, bool completes) {
    integrator_.begin_step(dt, predictor, completes);
    auto outcome = integrator_.iterate_to_tolerance();
    if (outcome) iterations_ += outcome->iterations;
    return outcome;
  }

  Result<void> report(const Outcome& outcome, std::uint64_t last_step) {
    ++steps_;
    const Balance balance = integrator_.balance();
    unbalance_ = balance.unbalance;
    const State& state = integrator_.committed();
    progress_.show({state.step, last_step, state.time, outcome.iterations, unbalance_});
    return results_.step({state, balance, outcome.iterations});
  }

  [[nodiscard]] Error stopped() const {
    return {ErrorKind::interrupted, fmt::format("interrupted after step {}", integrator_.committed().step)};
  }

  const Case& case_;
  Integrator integrator_;
  Results results_;
  Progress progress_;
  int steps_ = 0, iterations_ = 0, rejected_ = 0;
  double unbalance_ = 0;
};

} // namespace

Result<void> run(const Case& c) {
  return Run(c)();
}

Result<void> run_file(const std::filesystem::path& file) {
  const auto c = load_case(file);
  if (!c) return c.error();
  return run(*c);
}

} // namespace drogue::structure
