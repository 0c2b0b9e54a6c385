// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "structure_solver/model.hpp"

namespace drogue::structure {

/// Stresses and tensions of a configuration, for output.
///
/// Cells run over the batches of the model in order. Nodal stresses are means over the adjoining membranes
/// and solids, weighted with N_a^2 dV; nodes on lines alone have 0.
struct StressFields {
  std::vector<double>
      cell_largest; ///< largest principal second Piola-Kirchhoff stress, mean of the element; 0 on lines
  std::vector<double> cell_smallest;
  /// {cells, 3}: axes of the two, unit vectors of either sign along F e in the current configuration, means
  /// of the element; a line has its own axis and no second one.
  std::vector<double> cell_largest_direction;
  std::vector<double> cell_smallest_direction;
  std::vector<double> cell_tension; ///< tension of a line [force]; 0 on other elements
  /// 0 slack, 1 wrinkled, 2 taut (WrinkleState), mean over a membrane's points; a line is slack or taut.
  std::vector<double> cell_wrinkle_state;
  std::vector<double> nodal_largest;  ///< {nodes}
  std::vector<double> nodal_smallest; ///< {nodes}
  double max_stress = 0;              ///< over the quadrature points; 0 without any
  double min_stress = 0;
  double max_tension = 0;
  double slack_fraction = 0; ///< of all tension-only elements; 0 without any
  /// Share of the membranes' reference area that is wrinkled or slack; 0 without membranes.
  double wrinkled_fraction = 0;
};

/// @param u displacement, {3 nodes}
/// @param time tells the natural lengths
[[nodiscard]] StressFields stress_fields(const Model& model, std::span<const double> u, double time);

} // namespace drogue::structure
