// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/config/config.hpp"
#include "structure_solver/model.hpp"
#include "structure_solver/settings.hpp"

namespace drogue::structure {

/// A fixed material point of the structure, as a weighted mean of nodes.
struct ProbePoint {
  std::string name;
  std::vector<std::int32_t> nodes;
  std::vector<double> weights;
  /// From the position asked for to the point [length].
  double distance = 0;

  /// @param values {nodes, 3}
  [[nodiscard]] std::array<double, 3> operator()(std::span<const double> values) const;
};

/// The point of the reference configuration's elements that is nearest to a probe's position. Membranes count
/// by the flat triangles between their nodes, so that the value is linear on them and exact at nodes.
[[nodiscard]] ProbePoint locate(const Model& model, const ProbeSettings& probe);

/// Reports probes that are not on the structure: further from it than 1 % of its size.
void check_probes(const Settings& settings, const Model& model, config::Report& report);

} // namespace drogue::structure
