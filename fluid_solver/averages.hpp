// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "common/io/state_file.hpp"

namespace drogue::fluid {

/// Mean and root mean square of the fluctuations of many values over time, updated step by step without
/// cancellation [welford1962].
class RunningMoments {
 public:
  /// Counts `values` with the weight `dt`. The first call fixes their number.
  void add(double dt, std::span<const double> values);
  /// Replaces the values' mean and squares, {...} to {...}, when their places change.
  template <class Map>
  void map(Map&& function) {
    if (empty()) return;
    mean_ = function(mean_);
    squares_ = function(squares_);
  }
  [[nodiscard]] bool empty() const { return weight_ == 0; }
  /// Time counted so far.
  [[nodiscard]] double weight() const { return weight_; }
  [[nodiscard]] const std::vector<double>& mean() const { return mean_; }
  [[nodiscard]] std::vector<double> rms() const;

  /// As arrays "average_NAME_..." of a state; nothing when empty. Order of the values: reorder(values).
  template <class Reorder>
  void save(const std::string& name, io::State& state, Reorder&& reorder) const {
    if (empty()) return;
    state.add("average_" + name + "_time", {1}, {weight_});
    for (const auto& [part, values] : {std::pair{"_mean", &mean_}, std::pair{"_squares", &squares_}})
      state.add("average_" + name + part, {values->size()}, reorder(*values));
  }
  template <class Reorder>
  void load(const std::string& name, const io::State& state, Reorder&& reorder) {
    *this = {};
    const io::StateArray* time = state.find("average_" + name + "_time");
    const io::StateArray* mean = state.find("average_" + name + "_mean");
    const io::StateArray* squares = state.find("average_" + name + "_squares");
    if (time == nullptr || mean == nullptr || squares == nullptr || time->values.size() != 1) return;
    weight_ = time->values[0];
    mean_ = reorder(mean->values);
    squares_ = reorder(squares->values);
  }

 private:
  double weight_ = 0;
  std::vector<double> mean_;
  std::vector<double> squares_; ///< weighted squares of the fluctuations
};

/// Of the fields and forces of a run, on every rank.
struct FieldAverages {
  RunningMoments velocity; ///< {n, 3}
  RunningMoments pressure; ///< {n} kinematic
  RunningMoments forces;   ///< {reports, 3} totals
};

} // namespace drogue::fluid
