// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace drogue::test {

/// A disc of triangles in z = 0: a node in the middle and rings of the given radii, ring k of 6 min(k,
/// around) nodes. Groups `fluid` and `wall`, the edges of the outermost ring.
inline mesh::Mesh disc_mesh(const std::vector<double>& radii, int around) {
  mesh::Mesh m;
  m.points = {0, 0, 0};
  mesh::ElementBlock disc{"fluid", mesh::ElementKind::tri3, {}}, wall{"wall", mesh::ElementKind::line2, {}};
  const auto add = [&disc](int a, int b, int c) { disc.nodes.insert(disc.nodes.end(), {a, b, c}); };
  int inner_first = 0, inner_sides = 0; // nodes of the last ring: 6 inner_sides
  for (std::size_t k = 0; k < radii.size(); ++k) {
    const int sides = std::min(static_cast<int>(k) + 1, around), n = 6 * sides;
    const int first = m.node_count();
    for (int j = 0; j < n; ++j) {
      const double angle = 2 * std::numbers::pi * j / n;
      m.points.insert(m.points.end(), {radii[k] * std::cos(angle), radii[k] * std::sin(angle), 0});
    }
    const auto outer = [&](int j) { return first + j % n; };
    const auto inner = [&](int j) { return inner_first + (inner_sides == 0 ? 0 : j % (6 * inner_sides)); };
    for (int sector = 0; sector < 6; ++sector)
      for (int j = 0; j < sides; ++j) {
        const int out = sector * sides + j, in = sector * inner_sides + j;
        add(outer(out), outer(out + 1), inner(in));
        if (j < inner_sides) add(inner(in), outer(out + 1), inner(in + 1));
      }
    inner_first = first;
    inner_sides = sides;
  }
  const int n = 6 * inner_sides;
  for (int j = 0; j < n; ++j)
    wall.nodes.insert(wall.nodes.end(), {inner_first + j, inner_first + (j + 1) % n});
  m.blocks = {disc, wall};
  return m;
}

} // namespace drogue::test
