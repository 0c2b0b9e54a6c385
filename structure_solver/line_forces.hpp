// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/config/config.hpp"
#include "structure_solver/fields.hpp"
#include "structure_solver/model.hpp"

namespace drogue::structure {

/// The net force [force] that the lines of a group exert on the nodes of another: their tensions along the
/// lines with one end there.
struct LineForce {
  struct End {
    std::size_t cell = 0;    ///< the line, in the order of StressFields
    std::int32_t node = 0;   ///< pulled at
    std::int32_t beyond = 0; ///< the line's other node
  };
  std::string name;
  std::vector<End> ends;

  /// @param u displacement {nodes, 3} of the configuration that `stress` belongs to
  [[nodiscard]] std::array<double, 3> operator()(const Model& model, const StressFields& stress,
                                                 std::span<const double> u) const;
};

/// Those of the settings. Reports, and leaves out: a group that is none of a cable or truss, an unknown group
/// of nodes, no line that ends there, a name used twice.
[[nodiscard]] std::vector<LineForce> line_forces(const Settings& settings, const Model& model,
                                                 config::Report& report);

} // namespace drogue::structure
