// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <limits>

#include "common/mesh/mesh.hpp"

namespace drogue::test {

/// A mesh with every kind of element, coordinates that no short decimal represents, and two fields:
/// "complete" has values everywhere, "partial" (3 components) only on the first four nodes.
inline mesh::Mesh every_kind() {
  using mesh::ElementKind;
  mesh::Mesh m;
  for (int i = 0; i < 12; ++i)
    m.points.insert(m.points.end(),
                    {std::sin(i + 0.1), std::cos(7.0 * i) / 3, i % 2 == 0 ? 1e-17 * i : 0.1 * i});
  m.blocks = {
      {"fluid", ElementKind::tet4, {0, 1, 2, 3, 4, 5, 6, 7}},
      {"wall", ElementKind::tri3, {2, 1, 0, 3, 4, 5}},
      {"wall", ElementKind::quad4, {0, 1, 2, 3}},
      {"curved", ElementKind::tri6, {0, 1, 2, 3, 4, 5}},
      {"canopy", ElementKind::quad9, {8, 9, 10, 11, 0, 1, 2, 3, 4, 4, 3, 2, 1, 0, 11, 10, 9, 8}},
      {"lines", ElementKind::line2, {0, 8, 8, 9}},
      {"wall", ElementKind::line3, {1, 3, 5}},
      {"masses", ElementKind::point1, {7, 11}},
  };
  m.node_fields["complete"].values.resize(12);
  for (std::size_t i = 0; i < 12; ++i)
    m.node_fields["complete"].values[i] = std::exp(1.0 / (1.0 + static_cast<double>(i)));
  m.node_fields["partial"] = {3, std::vector<double>(36, std::numeric_limits<double>::quiet_NaN())};
  for (std::size_t i = 0; i < 12; ++i)
    m.node_fields["partial"].values[i] = std::sqrt(2.0 + static_cast<double>(i));
  return m;
}

} // namespace drogue::test
