// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/config/expression.hpp"
#include "structure_solver/length_schedule.hpp"

namespace drogue::structure {

/// Drag of points (one node each) or of lines (two nodes each).
struct DragLoad {
  std::string name;
  std::string field;
  std::vector<std::int32_t> nodes; ///< {count, nodes_per_element}
  int nodes_per_element = 1;
  double k = 0;            ///< 1/2 rho C_d A of a point, 1/2 rho C_d d of a line
  bool cross_flow = false; ///< lines: only the wind across them counts
  /// Velocity of the air at the current position x, y, z and the time t.
  config::VectorExpression air_velocity;
};

/// The natural length of a batch of lines as a function of time.
struct LengthControl {
  std::string name;
  std::string field;
  std::size_t batch = 0; ///< index in Model::batches
  LengthSchedule schedule;
};

} // namespace drogue::structure
