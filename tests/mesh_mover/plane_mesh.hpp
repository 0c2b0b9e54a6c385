// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace drogue::test {

/// A rectangle of two triangles a cell on a grid, in the plane z = 0.5, without the cells for which
/// `is_hole(i, j)` holds. Groups: "fluid", the sides "x0", "x1", "y0", "y1", and "body" for the rim of the
/// hole.
inline mesh::Mesh plane_mesh(const std::vector<double>& xs, const std::vector<double>& ys,
                             const std::function<bool(int, int)>& is_hole) {
  const auto nx = static_cast<int>(xs.size()) - 1, ny = static_cast<int>(ys.size()) - 1;
  mesh::Mesh mesh;
  std::vector<std::int32_t> number(xs.size() * ys.size(), -1);
  const auto node = [&](int i, int j) {
    auto& id = number[static_cast<std::size_t>(i * (ny + 1) + j)];
    if (id < 0) {
      id = mesh.node_count();
      mesh.points.insert(mesh.points.end(),
                         {xs[static_cast<std::size_t>(i)], ys[static_cast<std::size_t>(j)], 0.5});
    }
    return id;
  };
  const auto is_cell = [&](int i, int j) { return i >= 0 && j >= 0 && i < nx && j < ny && !is_hole(i, j); };
  std::map<std::string, mesh::ElementBlock> lines;
  const auto add_side = [&](std::int32_t a, std::int32_t b, int i, int j) { // towards the cell (i, j)
    if (is_cell(i, j)) return;
    const std::string group = i < 0 ? "x0" : i == nx ? "x1" : j < 0 ? "y0" : j == ny ? "y1" : "body";
    auto& block = lines[group];
    block.group = group;
    block.kind = mesh::ElementKind::line2;
    block.nodes.insert(block.nodes.end(), {a, b});
  };
  mesh::ElementBlock triangles{"fluid", mesh::ElementKind::tri3, {}};
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      if (!is_cell(i, j)) continue;
      const std::int32_t a = node(i, j), b = node(i + 1, j), c = node(i + 1, j + 1), d = node(i, j + 1);
      if ((i + j) % 2 == 0)
        triangles.nodes.insert(triangles.nodes.end(), {a, b, c, a, c, d});
      else
        triangles.nodes.insert(triangles.nodes.end(), {a, b, d, b, c, d});
      add_side(a, b, i, j - 1);
      add_side(b, c, i + 1, j);
      add_side(c, d, i, j + 1);
      add_side(d, a, i - 1, j);
    }
  for (auto& [group, block] : lines) mesh.blocks.push_back(std::move(block));
  mesh.blocks.push_back(std::move(triangles));
  return mesh;
}

} // namespace drogue::test
