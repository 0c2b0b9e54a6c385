// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/averages.hpp"

#include <cassert>
#include <cmath>

namespace drogue::fluid {

void RunningMoments::add(double dt, std::span<const double> values) {
  mean_.resize(values.size());
  squares_.resize(values.size());
  weight_ += dt;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double before = values[i] - mean_[i];
    mean_[i] += dt / weight_ * before;
    squares_[i] += dt * before * (values[i] - mean_[i]);
  }
}

std::vector<double> RunningMoments::rms() const {
  std::vector<double> out(squares_.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = std::sqrt(squares_[i] / weight_);
  return out;
}

} // namespace drogue::fluid
