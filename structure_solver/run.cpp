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

class Run {
 public:
  explicit Run(const Case& c)
      : case_(c),
        integrator_(*c.model, c.integrator_options(), c.start),
        results_(c.settings, *c.model, c.settings.output.directory) {}

  Result<void> operator()() {
    const TimeSettings& time = case_.settings.time;
    if (time.balanced_start) integrator_.balance_start();
    spdlog::info(
        "{} nodes, {} equations, {} to t = {}", case_.model->node_count(), case_.model->equation_count(),
        time.mode == TimeMode::dynamic ? "dynamics" : "damped dynamics",
        time.mode == TimeMode::dynamic ? case_.start.time + time.steps * time.step : time.largest_time);
    const Result<void> outcome = time.mode == TimeMode::dynamic ? dynamic() : static_equilibrium();
    progress_.finish();
    // What was reached is kept, whatever ended the run.
    DROGUE_TRY(results_.fields(integrator_.committed()));
    if (case_.settings.final_state && (outcome || outcome.error().kind == ErrorKind::interrupted))
      DROGUE_TRY(save_state(*case_.settings.final_state, *case_.model, integrator_.committed()));
    if (outcome)
      spdlog::info("done: {} steps, {} Newton iterations, {} rejected steps, {:.2f} s", steps_, iterations_,
                   rejected_, progress_.seconds());
    return outcome;
  }

 private:
  Result<void> dynamic() {
    const TimeSettings& time = case_.settings.time;
    for (int k = 0; k < time.steps; ++k) {
      const auto outcome = attempt(time.step, Integrator::Predictor::extrapolate);
      if (!outcome) return outcome.error();
      if (!outcome->converged)
        return numerical_error(
            "Newton did not converge in the step to t = {}: after {} iterations the correction is {:.3g} and "
            "the residual {:.3g} of the step's first; use a smaller time.step",
            integrator_.trial().time, outcome->iterations, outcome->correction, outcome->residual);
      DROGUE_TRY(accept(*outcome, case_.start.step + static_cast<std::uint64_t>(time.steps)));
      if (interrupted()) return stopped();
    }
    return {};
  }

  Result<void> static_equilibrium() {
    const TimeSettings& time = case_.settings.time;
    const double end = case_.start.time + time.largest_time;
    double dt = time.step;
    while (integrator_.committed().time < end) {
      const auto outcome = attempt(dt, Integrator::Predictor::hold);
      if (!outcome && !outcome.error().retryable) return outcome.error();
      if (!outcome || !outcome->converged) {
        integrator_.rollback();
        ++rejected_;
        dt *= failed_shrink;
        if (dt < smallest_step * time.step)
          return numerical_error("no static equilibrium: Newton fails at t = {} even with a step of {:.3g}",
                                 integrator_.committed().time, dt);
        continue;
      }
      DROGUE_TRY(accept(*outcome, 0));
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

  Result<Outcome> attempt(double dt, Integrator::Predictor predictor) {
    integrator_.begin_step(dt, predictor);
    auto outcome = integrator_.iterate_to_tolerance();
    if (outcome) iterations_ += outcome->iterations;
    return outcome;
  }

  Result<void> accept(const Outcome& outcome, std::uint64_t last_step) {
    integrator_.commit();
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
