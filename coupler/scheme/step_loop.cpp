// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/scheme/step_loop.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <spdlog/spdlog.h>

#include "coupler/acceleration/relaxation.hpp"
#include "coupler/stop.hpp"

namespace drogue::coupler {
namespace {

/// Watches a residual that should fall.
class Stall {
 public:
  enum class Verdict { moves, restart, stop };
  explicit Stall(int patience) : patience_(patience) {}
  Verdict judge(double residual) {
    if (residual < 0.9 * best_) {
      best_ = residual;
      since_ = 0;
      return Verdict::moves;
    }
    if (patience_ == 0 || ++since_ < patience_) return Verdict::moves;
    since_ = 0;
    return restarts_++ == 0 ? Verdict::restart : Verdict::stop;
  }

 private:
  int patience_;
  double best_ = std::numeric_limits<double>::infinity();
  int since_ = 0, restarts_ = 0;
};

/// A failure that a smaller step may cure counts as non-convergence; every other one ends the run.
bool curable(const Error& error) {
  return error.kind == ErrorKind::numerical && error.retryable;
}

} // namespace

Result<StepLoop> StepLoop::create(Participants& participants, Exchange& exchange, Results& results,
                                  const CaseSettings& settings) {
  StepLoop loop(participants, exchange, results, settings);
  const std::size_t size = exchange.structure_size();
  for (std::vector<double>* v :
       {&loop.n_.d, &loop.n_.v, &loop.d_, &loop.v_, &loop.d_tilde_, &loop.v_tilde_, &loop.work_})
    v->assign(size, 0.0);
  if (const auto& v = participants.structure_interface.velocity; !v.empty()) loop.n_.v = v;
  for (const double area : exchange.areas()) loop.weights_.insert(loop.weights_.end(), 3, area);
  loop.f_.assign(size, 0.0);
  loop.n_.f.assign(size, 0.0);
  loop.mean_n_.assign(size, 0.0);
  if (settings.loop.scheme == Scheme::parallel) {
    loop.x_.resize(2 * size);
    loop.h_.resize(2 * size);
    const std::vector<double> areas = loop.weights_;
    loop.weights_.insert(loop.weights_.end(), areas.begin(), areas.end());
  }
  if (settings.loop.scheme == Scheme::structure_first) {
    loop.x_.resize(size);
    loop.h_.resize(size);
  }
  DROGUE_TRY(loop.use_step(settings.time_step));
  return loop;
}

Result<void> StepLoop::use_step(double time_step) {
  auto& accelerator = accelerators_[time_step];
  if (!accelerator) {
    // In STRUCTURE_FIRST the structure gives the velocity anew in each iteration.
    const std::size_t passenger = settings_.loop.scheme == Scheme::structure_first ? 0 : d_.size();
    auto made = acceleration::make_accelerator(settings_.acceleration, weights_.size(), passenger, weights_);
    if (!made) return made.error();
    accelerator = std::move(*made);
  }
  accelerator_ = accelerator.get();
  return {};
}

Result<bool> StepLoop::advance(std::uint64_t step, double time, double time_step) {
  attempt_ = 0;
  step_unconverged_ = false;
  totals_before_ = totals_;
  results_before_ = results_.iterations_size();
  const auto done = advance(step, time, time_step, Part{});
  if (!done || !*done) return done;
  ++totals_.steps;
  totals_.most_iterations = std::max(totals_.most_iterations, totals_.iterations - totals_before_.iterations);
  totals_.unconverged += step_unconverged_ ? 1 : 0;
  return true;
}

/// A step of which nothing is committed can be taken back, by participants that can roll back.
bool StepLoop::may_stop() const {
  return stop::requested() && totals_.parts == totals_before_.parts &&
         participants_.who_cannot_roll_back().empty();
}

Result<bool> StepLoop::take_back(const Station& at) {
  DROGUE_TRY(participants_.roll_back(at));
  accelerator_->rollback();
  totals_ = totals_before_;
  DROGUE_TRY(results_.cut_iterations(results_before_));
  return false;
}

Result<bool> StepLoop::advance(std::uint64_t step, double time, double time_step, Part part) {
  Station at{step, 0, ++attempt_};
  DROGUE_TRY(use_step(time_step));
  const bool may_retry =
      settings_.loop.non_convergence == NonConvergence::retry && part.halvings < settings_.loop.max_halvings;
  auto outcome = iterate(at, time, time_step);
  if (!outcome) return outcome.error();
  if (outcome->stopped) return take_back(at);
  const auto finished = [&]() -> Result<bool> {
    DROGUE_TRY(finish(at, *outcome, time, time_step, part.is_last));
    return true;
  };
  if (outcome->converged) return finished();

  const std::string what = fmt::format("step {} (t = {:g}, length {:g}) did not converge: {}", at.step,
                                       time + time_step, time_step, outcome->trouble);
  if (settings_.loop.non_convergence == NonConvergence::accept && outcome->acceptable) {
    spdlog::warn("{}: accepted as the case says", what);
    return finished();
  }
  if (!may_retry) return numerical_error("{}", what);
  spdlog::warn("{}: rolled back, in halves", what);
  DROGUE_TRY(participants_.roll_back(at));
  accelerator_->rollback();
  ++totals_.retries;
  const auto first_half = advance(step, time, 0.5 * time_step, {part.halvings + 1, false});
  if (!first_half || !*first_half) return first_half;
  return advance(step, time + 0.5 * time_step, 0.5 * time_step, {part.halvings + 1, part.is_last});
}

LoadShare StepLoop::load_share(double time) const {
  return {settings_.load_factor(0, 0, 0, time), settings_.withheld_first_load(0, 0, 0, time)};
}

/// The fluid's walls, for the displacement d_ and its rate v_.
void StepLoop::set_wall_velocity(double time_step) {
  if (settings_.loop.wall_velocity == WallVelocity::structure_rate) {
    v_start_ = n_.v; // the structure's committed rate, not the last iterate's
    return;
  }
  for (std::size_t i = 0; i < d_.size(); ++i) v_[i] = (d_[i] - n_.d[i]) / time_step;
  v_start_ = v_;
}

/// H once: of (d_, v_) and in PARALLEL of f_, or in STRUCTURE_FIRST of f_ alone, where (d_, v_) become what
/// the structure answers with.
Result<void> StepLoop::sweep(const Station& at, LoadShare share, double time_step) {
  if (settings_.loop.scheme == Scheme::structure_first) {
    DROGUE_TRY(exchange_.structure(at, d_, f_, d_tilde_, v_tilde_));
    d_ = d_tilde_;
    v_ = v_tilde_;
    set_wall_velocity(time_step);
    return exchange_.fluid(at, share, d_, v_, v_start_, record_);
  }
  set_wall_velocity(time_step);
  const bool parallel = settings_.loop.scheme == Scheme::parallel;
  return exchange_.evaluate(at, share, d_, v_, v_start_,
                            parallel ? std::span<const double>(f_) : std::span<const double>(), d_tilde_,
                            v_tilde_, record_);
}

Result<StepLoop::Outcome> StepLoop::iterate(Station& at, double time, double time_step) {
  const LoopSettings& loop = settings_.loop;
  const LoadShare share = load_share(time + time_step);
  DROGUE_TRY(participants_.begin_step(at, time, time_step));
  accelerator_->begin_step();
  predict(time_step);
  if (participants_.load_time() == LoadTime::extrapolated_mean && known_levels_ > 1)
    exchange_.extrapolate(mean_n_, time_step / (time_step + n_.time_step));
  Stall stall(loop.stall);

  Outcome outcome;
  double first_residual = 0;
  for (int k = 1; k <= loop.max_iterations; ++k) {
    at.iteration = static_cast<std::uint32_t>(k);
    record_ = {};
    const auto evaluated = sweep(at, share, time_step);
    if (!evaluated && !curable(evaluated.error())) return evaluated.error();
    if (!evaluated) {
      outcome.trouble = evaluated.error().message;
      return outcome;
    }
    outcome.iterations = k;
    ++totals_.iterations;
    measure(time_step);
    learn_added_mass(k);
    record_.step = static_cast<double>(at.step);
    record_.attempt = at.attempt;
    record_.iteration = k;
    record_.time = time + time_step;
    if (k == 1) first_residual = record_.residual_absolute;
    const bool small = is_small(first_residual);
    const std::string inner_trouble = participants_.inner_trouble(loop.inner_residual);
    record_.inner_converged = inner_trouble.empty() ? 1 : 0;
    outcome.converged = small && inner_trouble.empty() && k >= loop.min_iterations;
    outcome.trouble = small ? inner_trouble : "";
    const bool diverged = !(record_.residual_absolute <= loop.divergence);
    const Stall::Verdict verdict = small ? Stall::Verdict::moves : stall.judge(record_.residual_absolute);
    if (verdict == Stall::Verdict::restart) {
      spdlog::warn("step {}: the residual does not fall any more, iteration {}: the accelerator starts anew",
                   at.step, k);
      accelerator_->forget();
    }
    const bool goes_on = !outcome.converged && !diverged && verdict != Stall::Verdict::stop;
    if (goes_on && k < loop.max_iterations) DROGUE_TRY(next_iterate());
    if (loop.scheme == Scheme::serial) f_.assign(exchange_.force().begin(), exchange_.force().end());
    DROGUE_TRY(results_.iteration(record_));
    spdlog::debug("step {} iteration {}: residual {:.2e} of the increment", at.step, k,
                  record_.residual_relative);
    if (outcome.converged) return outcome;
    if (may_stop()) {
      outcome.stopped = true;
      return outcome;
    }
    if (diverged) {
      outcome.trouble = fmt::format("the residual grew to {:.3g}", record_.residual_absolute);
      return outcome;
    }
    if (!goes_on) {
      outcome.trouble =
          fmt::format("the residual stalls at {:.2e} of the increment (asked: {:.0e}) after {} iterations, "
                      "with a new start of the accelerator in between",
                      record_.residual_relative, loop.relative, k);
      break;
    }
  }
  outcome.acceptable = true;
  if (outcome.trouble.empty())
    outcome.trouble = fmt::format("residual {:.2e} of the increment after {} iterations (asked: {:.0e})",
                                  record_.residual_relative, outcome.iterations, loop.relative);
  return outcome;
}

/// Relaxation carries the follower's own error along, a factor 1 - omega smaller in each iteration: there the
/// unknown is the field that is asked to converge.
StepLoop::Unknown StepLoop::unknown() {
  const auto method = settings_.acceleration.method;
  const bool relaxes = method == acceleration::Method::constant || method == acceleration::Method::aitken;
  if (relaxes || settings_.loop.wall_velocity == WallVelocity::mesh_rate) return {d_, d_tilde_, v_, v_tilde_};
  return {v_, v_tilde_, d_, d_tilde_};
}

/// The load weighs as the velocity it answers to, by the first two iterates of a run: false until there are
/// two. (The first residuals say nothing: a wall at rest bears next to no load.)
bool StepLoop::weigh_load(const Unknown& u) {
  const std::span<const double> f_tilde = exchange_.force();
  const auto change = [](std::span<const double> now, std::vector<double>& before) {
    before.resize(now.size(), 0.0);
    for (std::size_t i = 0; i < now.size(); ++i) before[i] = now[i] - before[i];
  };
  if (load_scale_ > 0) return true;
  if (!x_before_.empty()) {
    change(u.x, x_before_);
    change(f_tilde, h_before_);
    const double of_unknown = exchange_.norm(x_before_), of_load = density_norm(h_before_);
    if (of_unknown > 0 && of_load > 0) load_scale_ = of_unknown / of_load;
  }
  x_before_ = u.x;
  h_before_.assign(f_tilde.begin(), f_tilde.end());
  return load_scale_ > 0;
}

/// The interface's unknown and load density as one vector.
Result<void> StepLoop::next_of_both(const Unknown& u) {
  const std::size_t n = d_.size();
  const std::span<const double> f_tilde = exchange_.force();
  if (!weigh_load(u)) {
    const double omega = settings_.acceleration.relaxation;
    acceleration::relax(omega, u.x, u.h, u.x);
    acceleration::relax(omega, u.x_follower, u.h_follower, u.x_follower);
    acceleration::relax(omega, f_, f_tilde, f_);
    return {};
  }
  std::copy(u.x.begin(), u.x.end(), x_.begin());
  std::copy(u.h.begin(), u.h.end(), h_.begin());
  for (std::size_t i = 0; i < n; ++i) {
    x_[n + i] = load_scale_ * f_[i] / weights_[i];
    h_[n + i] = load_scale_ * f_tilde[i] / weights_[i];
  }
  if (!accelerator_->next({x_, h_, u.x_follower, u.h_follower}, x_, u.x_follower))
    return numerical_error("the accelerator met a value that is not finite");
  std::copy(x_.begin(), x_.begin() + static_cast<std::ptrdiff_t>(n), u.x.begin());
  for (std::size_t i = 0; i < n; ++i) f_[i] = x_[n + i] * weights_[i] / load_scale_;
  return {};
}

/// The load density alone.
Result<void> StepLoop::next_load() {
  const std::span<const double> f_tilde = exchange_.force();
  for (std::size_t i = 0; i < f_.size(); ++i) {
    x_[i] = f_[i] / weights_[i];
    h_[i] = f_tilde[i] / weights_[i];
  }
  if (!accelerator_->next({x_, h_}, x_))
    return numerical_error("the accelerator met a value that is not finite");
  for (std::size_t i = 0; i < f_.size(); ++i) f_[i] = x_[i] * weights_[i];
  return {};
}

Result<void> StepLoop::next_iterate() {
  const Unknown u = unknown();
  if (settings_.loop.scheme == Scheme::parallel) {
    DROGUE_TRY(next_of_both(u));
  } else if (settings_.loop.scheme == Scheme::structure_first) {
    DROGUE_TRY(next_load());
  } else if (!accelerator_->next({u.x, u.h, u.x_follower, u.h_follower}, u.x, u.x_follower)) {
    return numerical_error("the accelerator met a value that is not finite");
  }
  record_.columns = accelerator_->used_columns();
  record_.dropped_columns = accelerator_->dropped_columns();
  totals_.used_columns += record_.columns;
  totals_.dropped_columns += record_.dropped_columns;
  return {};
}

Result<void> StepLoop::finish(const Station& at, const Outcome& outcome, double time, double time_step,
                              bool whole_step) {
  DROGUE_TRY(participants_.commit(at, whole_step));
  accelerator_->end_step(outcome.converged);
  std::swap(n_minus_2_, n_minus_1_);
  std::swap(n_minus_1_, n_);
  n_ = {d_tilde_, v_tilde_, {exchange_.force().begin(), exchange_.force().end()}, time_step};
  mean_n_.assign(exchange_.given_force().begin(), exchange_.given_force().end());
  known_levels_ = std::min(known_levels_ + 1, 3);

  ++totals_.parts;
  step_unconverged_ = step_unconverged_ || !outcome.converged;

  StepRecord s;
  s.time = time + time_step;
  s.force = record_.force_fluid;
  for (std::size_t i = 0; i < 3; ++i) s.drag_coefficient += settings_.drag_weights[i] * s.force[i];
  const LoadShare share = load_share(s.time);
  s.load_factor = share.factor;
  s.withheld_first_load = share.withheld;
  s.mean_displacement = exchange_.mean(n_.d);
  s.vector_area = exchange_.vector_area(n_.d);
  s.iterations = outcome.iterations;
  s.converged = outcome.converged ? 1 : 0;
  DROGUE_TRY(results_.step(s));
  return participants_.new_mesh() ? change_mesh(at, s.time) : Result<void>();
}

/// Secants and levels stay: nothing changes on the interface.
Result<void> StepLoop::change_mesh(const Station& at, double time) {
  const v1::NewMesh mesh = *participants_.new_mesh();
  const auto change =
      participants_.replace_mesh({at.step, 0, at.attempt}, {mesh.file(), mesh.mesh_hash()}, false);
  if (!change) return change.error();
  ++totals_.new_meshes;
  spdlog::info(
      "step {} (t = {:g}): new fluid mesh of {} nodes in place of {}: {}. The flow was carried over with a "
      "change of {:.2e} of its flux, {:.2e} of its momentum, {:.2e} of its energy",
      at.step, time, change->nodes_after, change->nodes_before, mesh.reason(), change->mass_defect,
      change->momentum_defect, change->energy_defect);
  return results_.new_mesh({static_cast<double>(at.step), time, static_cast<double>(change->nodes_before),
                            static_cast<double>(change->nodes_after), change->mass_defect,
                            change->momentum_defect, change->energy_defect});
}

} // namespace drogue::coupler
