// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <numbers>
#include <string>
#include <vector>

#include "parachute_mesher/structure_mesh.hpp"

namespace drogue::parachute {

/// One canopy of every family, with its lines, small meshes.
struct Example {
  std::string name;
  Canopy canopy;
  Rigging rigging;
  Subdivision rows;
  double area = 0; ///< of the cloth, in closed form
  int rings = 0;   ///< pieces of cloth with a hole; 0: a cross
};

inline std::vector<Example> examples() {
  constexpr double pi = std::numbers::pi;
  const Rigging lines{.line_length = 12, .line_elements = 3, .vent_elements = 2, .confluence_distance = 0.5};
  const Subdivision rows{.main_rows = 6, .across_vent = 2, .across_seam = 2, .across_skirt = 2};
  Subdivision with_skirt = rows;
  with_skirt.skirt_rows = 2;
  Rigging annular = lines;
  annular.vent_elements = 0;
  annular.inner_line_elements = 3;
  const Canopy flat{.diameter = 10, .vent_ratio = 0.1, .skirt_ratio = 0, .gores = 16};
  Canopy skirt = flat, cone = flat, hemisphere = flat, ring = flat, slots = flat, cross = flat;
  skirt.skirt_ratio = 0.1;
  cone.shape = Shape::conical;
  cone.cone_angle = pi / 6;
  hemisphere.shape = Shape::hemispherical;
  ring.vent_ratio = 0.6;
  slots.gaps = {{0.4, 0.44}, {0.6, 0.63}, {0.8, 0.82}};
  cross.shape = Shape::cross;
  cross.arm_width_ratio = 0.3;
  cross.lines_per_arm = 4;
  const auto disk = [](double r) { return pi * r * r; };
  const Subdivision arms{.main_rows = 5, .across_seam = 6};
  return {
      {"flat_circular", flat, lines, rows, disk(5) - disk(0.5), 1},
      {"extended_skirt", skirt, lines, with_skirt, disk(5) - disk(0.5) + disk(5) - disk(4), 1},
      {"conical", cone, lines, rows, (disk(5) - disk(0.5)) / std::cos(pi / 6), 1},
      // Archimedes: a band of a sphere has the area of the cylinder around it.
      {"hemispherical", hemisphere, lines, rows, 2 * pi * 5 * 5 * std::sqrt(1 - 0.01), 1},
      {"annular", ring, annular, rows, disk(5) - disk(3), 1},
      {"ringslot", slots, lines, rows,
       disk(5) - disk(0.5) - (disk(2.2) - disk(2)) - (disk(3.15) - disk(3)) - (disk(4.1) - disk(4)), 4},
      {"cross", cross, lines, arms, 2 * 10 * 3 - 3 * 3, 0},
  };
}

inline constexpr mesh::ElementKind membrane_kinds[] = {mesh::ElementKind::tri3, mesh::ElementKind::tri6,
                                                       mesh::ElementKind::quad4, mesh::ElementKind::quad9};

inline mesh::Mesh make(const Example& example, mesh::ElementKind kind) {
  return structure_mesh(example.canopy, example.rigging,
                        {.file = {}, .element = kind, .rows = cloth_rows(example.canopy, example.rows)});
}

} // namespace drogue::parachute
