// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace drogue::test {

using Grid = std::array<std::vector<double>, 3>;

/// n + 1 equidistant values from a to b.
inline std::vector<double> uniform(double a, double b, int n) {
  std::vector<double> values;
  for (int i = 0; i <= n; ++i) values.push_back(a + (b - a) * i / n);
  return values;
}

/// 2 n + 1 values from -half to half, closer together near zero.
inline std::vector<double> graded(double half, int n, double power) {
  std::vector<double> values;
  for (int i = -n; i <= n; ++i) {
    const double s = static_cast<double>(i) / n;
    values.push_back(half * (s < 0 ? -1 : 1) * std::pow(std::abs(s), power));
  }
  return values;
}

/// A block of six tetrahedra a cell on a grid, without the cells for which `is_hole(i, j, k)` holds. Groups:
/// "fluid", the sides "x0", "x1", "y0" ... and "body" for the faces of the hole.
template <class IsHole>
mesh::Mesh box_mesh(const Grid& grid, IsHole is_hole) {
  const std::array<int, 3> n = {static_cast<int>(grid[0].size()), static_cast<int>(grid[1].size()),
                                static_cast<int>(grid[2].size())};
  std::vector<std::int32_t> number(static_cast<std::size_t>(n[0] * n[1] * n[2]), -1);
  mesh::Mesh mesh;
  const auto node = [&](int i, int j, int k) {
    auto& id = number[static_cast<std::size_t>((i * n[1] + j) * n[2] + k)];
    if (id < 0) {
      id = mesh.node_count();
      mesh.points.insert(mesh.points.end(),
                         {grid[0][static_cast<std::size_t>(i)], grid[1][static_cast<std::size_t>(j)],
                          grid[2][static_cast<std::size_t>(k)]});
    }
    return id;
  };
  mesh::ElementBlock tets{"fluid", mesh::ElementKind::tet4, {}};
  const int paths[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (int i = 0; i + 1 < n[0]; ++i)
    for (int j = 0; j + 1 < n[1]; ++j)
      for (int k = 0; k + 1 < n[2]; ++k) {
        if (is_hole(i, j, k)) continue;
        for (int p = 0; p < 6; ++p) {
          std::array<int, 3> at = {i, j, k};
          std::array<std::int32_t, 4> tet{};
          tet[0] = node(at[0], at[1], at[2]);
          for (std::size_t s = 0; s < 3; ++s) {
            ++at[static_cast<std::size_t>(paths[p][s])];
            tet[s + 1] = node(at[0], at[1], at[2]);
          }
          if (p >= 3) std::swap(tet[2], tet[3]); // odd permutations turn the element inside out
          tets.nodes.insert(tets.nodes.end(), tet.begin(), tet.end());
        }
      }
  std::map<std::array<std::int32_t, 3>, std::pair<int, std::array<std::int32_t, 3>>> faces;
  const int corners[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  for (std::size_t e = 0; e < tets.nodes.size(); e += 4)
    for (const auto& c : corners) {
      std::array<std::int32_t, 3> face{};
      for (std::size_t a = 0; a < 3; ++a) face[a] = tets.nodes[e + static_cast<std::size_t>(c[a])];
      auto key = face;
      std::sort(key.begin(), key.end());
      ++faces[key].first;
      faces[key].second = face;
    }
  std::map<std::string, mesh::ElementBlock> boundary;
  for (const auto& [key, face] : faces) {
    if (face.first == 2) continue;
    std::string group = "body";
    for (std::size_t c = 0; c < 3; ++c)
      for (const double end : {grid[c].front(), grid[c].back()})
        if (std::all_of(key.begin(), key.end(), [&](std::int32_t v) {
              return mesh.points[3 * static_cast<std::size_t>(v) + c] == end;
            }))
          group = std::string(1, "xyz"[c]) + (end == grid[c].front() ? "0" : "1");
    auto& block = boundary[group];
    block.group = group;
    block.kind = mesh::ElementKind::tri3;
    block.nodes.insert(block.nodes.end(), face.second.begin(), face.second.end());
  }
  for (auto& [group, block] : boundary) mesh.blocks.push_back(std::move(block));
  mesh.blocks.push_back(std::move(tets));
  return mesh;
}

} // namespace drogue::test
