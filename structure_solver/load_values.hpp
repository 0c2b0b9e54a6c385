// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "common/base/result.hpp"
#include "structure_solver/model.hpp"

namespace drogue::structure {

/// What the config prescribes at one time: dead nodal forces, the nodal values of follower pressures, and
/// natural lengths.
struct LoadValues {
  double time = 0;
  /// Factor on all loads: less than one while a static run builds them up.
  double factor = 1;
  /// {3 nodes} [force]: gravity, tractions, nodal forces.
  std::vector<double> force;
  /// One field over all nodes for each entry of Model::pressures [stress].
  std::vector<std::vector<double>> pressure;
  /// Natural length of each of Model::batches relative to that of its Reference.
  std::vector<double> length_factor;

  /// (1 - alpha) a + alpha b
  [[nodiscard]] static LoadValues blend(const LoadValues& a, const LoadValues& b, double alpha);
};

/// The loads at a time, times `factor` (lengths are not scaled).
/// Errors (numerical): a load that is not finite, a length that is not positive; with its group.
[[nodiscard]] Result<LoadValues> evaluate_loads(const Model& model, double time, double factor = 1);

/// LoadValues::length_factor alone; lengths that make no sense count as unchanged.
[[nodiscard]] std::vector<double> length_factors(const Model& model, double time);

/// The loads that have no value at a time, with the path of each in the config: what `check` reports.
struct LoadFault {
  std::string field;
  std::string text;
};
[[nodiscard]] std::vector<LoadFault> load_faults(const Model& model, double time);

} // namespace drogue::structure
