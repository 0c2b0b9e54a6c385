// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace drogue::test {

/// Adds a layer of triangles over 0 <= x <= L with rows of nodes at the heights y, in groups `fluid`, `low`
/// and `high` for its two faces, `ends`. Edges have the fluid on their left. Layers do not share nodes.
inline void add_layer(mesh::Mesh& m, double L, int nx, const std::vector<double>& y, const std::string& low,
                      const std::string& high) {
  const std::int32_t first = m.node_count();
  const int ny = static_cast<int>(y.size()) - 1;
  const auto id = [&](int i, int j) { return first + j * (nx + 1) + i; };
  const auto block = [&](const std::string& group, mesh::ElementKind kind) -> std::vector<std::int32_t>& {
    for (auto& b : m.blocks)
      if (b.group == group) return b.nodes;
    m.blocks.push_back({group, kind, {}});
    return m.blocks.back().nodes;
  };
  for (const double height : y)
    for (int i = 0; i <= nx; ++i) m.points.insert(m.points.end(), {L * i / nx, height, 0.0});
  const auto add = [&](const std::string& group, mesh::ElementKind kind,
                       std::initializer_list<std::int32_t> nodes) {
    auto& to = block(group, kind);
    to.insert(to.end(), nodes);
  };
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) // mirrored about the middle
      if (2 * i < nx)
        add("fluid", mesh::ElementKind::tri3,
            {id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j), id(i + 1, j + 1), id(i, j + 1)});
      else
        add("fluid", mesh::ElementKind::tri3,
            {id(i, j), id(i + 1, j), id(i, j + 1), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)});
  for (int i = 0; i < nx; ++i) {
    add(low, mesh::ElementKind::line2, {id(i, 0), id(i + 1, 0)});
    add(high, mesh::ElementKind::line2, {id(i + 1, ny), id(i, ny)});
  }
  for (int j = 0; j < ny; ++j)
    add("ends", mesh::ElementKind::line2, {id(0, j + 1), id(0, j), id(nx, j), id(nx, j + 1)});
}

/// n + 1 heights from a to b whose steps shrink towards b, to a third of the first.
inline std::vector<double> finer_towards(double b, double a, int n) {
  std::vector<double> y;
  for (int j = 0; j <= n; ++j) {
    const double s = static_cast<double>(j) / n;
    y.push_back(a + (b - a) * (1.5 * s - 0.5 * s * s));
  }
  return y;
}

} // namespace drogue::test
