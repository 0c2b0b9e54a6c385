// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "structure_solver/model.hpp"

namespace drogue::structure {

/// A fixed material point of the structure, as a weighted mean of nodes.
struct ProbePoint {
  std::string name;
  std::vector<std::int32_t> nodes;
  std::vector<double> weights;

  /// @param values {nodes, 3}
  [[nodiscard]] std::array<double, 3> operator()(std::span<const double> values) const;
};

/// The point of the reference configuration's elements that is nearest to a probe's position. Membranes count
/// by the flat triangles between their nodes, so that the value is linear on them and exact at nodes.
[[nodiscard]] ProbePoint locate(const Model& model, const ProbeSettings& probe);

} // namespace drogue::structure
