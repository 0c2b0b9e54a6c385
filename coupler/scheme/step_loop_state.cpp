// SPDX-License-Identifier: GPL-3.0-or-later
// What a StepLoop puts into a checkpoint, and takes from it.
#include <array>
#include <optional>

#include "coupler/scheme/step_loop.hpp"

namespace drogue::coupler {
namespace {

void put(io::State& state, const std::string& name, std::vector<double> values) {
  const std::uint64_t size = values.size();
  state.add(name, {size}, std::move(values));
}

/// Takes arrays from a state; remembers the first that is missing or of a wrong size.
class Taker {
 public:
  explicit Taker(const io::State& state) : state_(state) {}
  /// @param size 0: any
  std::vector<double> vector(const std::string& name, std::size_t size = 0) {
    const io::StateArray* array = state_.find(name);
    if (array && (size == 0 || array->values.size() == size)) return array->values;
    if (!error_)
      error_ = array ? config_error("the coupler's state: array \"{}\" has {} values in place of {}", name,
                                    array->values.size(), size)
                     : config_error("the coupler's state has no array \"{}\"", name);
    return std::vector<double>(size, 0.0);
  }
  double number(const std::string& name) { return vector(name, 1)[0]; }
  [[nodiscard]] Result<void> outcome() const { return error_ ? Result<void>(*error_) : Result<void>(); }

 private:
  const io::State& state_;
  std::optional<Error> error_;
};

void put_accelerator(io::State& state, const std::string& name, const acceleration::State& a) {
  put(state, name + ".step", {static_cast<double>(a.step)});
  put(state, name + ".omega", {a.omega});
  put(state, name + ".column_step", {a.column_step.begin(), a.column_step.end()});
  put(state, name + ".column_dr", a.column_dr);
  put(state, name + ".column_dh", a.column_dh);
  put(state, name + ".column_dp", a.column_dp);
}

acceleration::State take_accelerator(Taker& from, const std::string& name) {
  acceleration::State a;
  a.step = static_cast<std::int64_t>(from.number(name + ".step"));
  a.omega = from.number(name + ".omega");
  for (const double step : from.vector(name + ".column_step"))
    a.column_step.push_back(static_cast<std::int64_t>(step));
  a.column_dr = from.vector(name + ".column_dr");
  a.column_dh = from.vector(name + ".column_dh");
  a.column_dp = from.vector(name + ".column_dp");
  return a;
}

std::vector<double> numbers(const LoopTotals& t) {
  return {static_cast<double>(t.steps),
          static_cast<double>(t.parts),
          static_cast<double>(t.iterations),
          static_cast<double>(t.most_iterations),
          static_cast<double>(t.unconverged),
          static_cast<double>(t.retries),
          static_cast<double>(t.new_meshes),
          t.used_columns,
          t.dropped_columns,
          t.added_mass_ratio};
}

LoopTotals totals_of(const std::vector<double>& n) {
  const auto count = [&](std::size_t i) { return static_cast<int>(n[i]); };
  return {count(0), count(1), count(2), count(3), count(4), count(5), count(6), n[7], n[8], n[9]};
}

} // namespace

void StepLoop::save(io::State& state) const {
  put(state, "known_levels", {static_cast<double>(known_levels_)});
  const std::array levels{&n_, &n_minus_1_, &n_minus_2_};
  for (std::size_t i = 0; i < static_cast<std::size_t>(known_levels_); ++i) {
    const std::string name = fmt::format("level_{}", i);
    put(state, name + ".d", levels[i]->d);
    put(state, name + ".v", levels[i]->v);
    put(state, name + ".load", levels[i]->f);
    put(state, name + ".time_step", {levels[i]->time_step});
  }
  put(state, "given_load", mean_n_);
  put(state, "first_load", exchange_.first_force());
  put(state, "load_scale", {load_scale_});
  put(state, "totals", numbers(totals_));
  std::vector<double> time_steps;
  for (const auto& [time_step, accelerator] : accelerators_) {
    put_accelerator(state, fmt::format("accelerator_{}", time_steps.size()), accelerator->save());
    time_steps.push_back(time_step);
  }
  put(state, "accelerators", std::move(time_steps));
}

Result<void> StepLoop::load(const io::State& state) {
  Taker from(state);
  const double known = from.number("known_levels");
  DROGUE_TRY(from.outcome());
  if (!(known >= 1 && known <= 3)) return config_error("the coupler's state has {} time levels", known);
  known_levels_ = static_cast<int>(known);
  const std::array levels{&n_, &n_minus_1_, &n_minus_2_};
  for (std::size_t i = 0; i < static_cast<std::size_t>(known_levels_); ++i) {
    const std::string name = fmt::format("level_{}", i);
    *levels[i] = {from.vector(name + ".d", d_.size()), from.vector(name + ".v", v_.size()),
                  from.vector(name + ".load", f_.size()), from.number(name + ".time_step")};
  }
  mean_n_ = from.vector("given_load", mean_n_.size());
  exchange_.set_first_force(from.vector("first_load"));
  load_scale_ = from.number("load_scale");
  totals_ = totals_of(from.vector("totals", numbers({}).size()));
  const std::vector<double> time_steps = from.vector("accelerators");
  DROGUE_TRY(from.outcome());
  for (std::size_t i = 0; i < time_steps.size(); ++i) {
    const acceleration::State saved = take_accelerator(from, fmt::format("accelerator_{}", i));
    DROGUE_TRY(from.outcome());
    DROGUE_TRY(use_step(time_steps[i]));
    DROGUE_TRY(accelerator_->restore(saved));
  }
  return {};
}

} // namespace drogue::coupler
