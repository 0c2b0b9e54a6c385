// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <functional>
#include <initializer_list>
#include <utility>

#include <Eigen/Dense>

#include "common/mesh/mesh.hpp"

/// Regular meshes of every element kind.
namespace drogue::structure::test {

using mesh::ElementBlock;
using mesh::ElementKind;

/// Adds the elements of one 3 x 3 patch of nodes p[j][i]: one of second order, or what fills its place.
inline void fill_patch(ElementBlock& block, const std::array<std::array<std::int32_t, 3>, 3>& p) {
  const auto add = [&](std::initializer_list<std::int32_t> nodes) {
    block.nodes.insert(block.nodes.end(), nodes);
  };
  if (block.kind == ElementKind::quad9) {
    add({p[0][0], p[0][2], p[2][2], p[2][0], p[0][1], p[1][2], p[2][1], p[1][0], p[1][1]});
    return;
  }
  if (block.kind == ElementKind::tri6) {
    add({p[0][0], p[0][2], p[2][2], p[0][1], p[1][2], p[1][1]});
    add({p[0][0], p[2][2], p[2][0], p[1][1], p[2][1], p[1][0]});
    return;
  }
  for (std::size_t j = 0; j < 2; ++j)
    for (std::size_t i = 0; i < 2; ++i) {
      if (block.kind == ElementKind::quad4) {
        add({p[j][i], p[j][i + 1], p[j + 1][i + 1], p[j + 1][i]});
      } else {
        add({p[j][i], p[j][i + 1], p[j + 1][i + 1]});
        add({p[j][i], p[j + 1][i + 1], p[j + 1][i]});
      }
    }
}

/// Adds the elements of one 3 x 3 x 3 patch of nodes p(i, j, k): one hexahedron, or the six tetrahedra around
/// its diagonal.
template <class Patch>
void fill_cell(ElementBlock& block, const Patch& p) {
  if (block.kind == ElementKind::hex27) {
    constexpr int g[27][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2},
                              {0, 2, 2}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 1, 0}, {2, 0, 1}, {1, 2, 0},
                              {2, 2, 1}, {0, 2, 1}, {1, 0, 2}, {0, 1, 2}, {2, 1, 2}, {1, 2, 2}, {1, 1, 0},
                              {1, 0, 1}, {0, 1, 1}, {2, 1, 1}, {1, 2, 1}, {1, 1, 2}, {1, 1, 1}};
    for (const auto& n : g) block.nodes.push_back(p(n[0], n[1], n[2]));
    return;
  }
  constexpr int axes[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}};
  constexpr int edges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {3, 0}, {2, 3}, {1, 3}};
  for (int t = 0; t < 6; ++t) {
    std::array<std::array<int, 3>, 4> corner{};
    for (std::size_t c = 1; c < 4; ++c) {
      corner[c] = corner[c - 1];
      corner[c][static_cast<std::size_t>(axes[t][c - 1])] = 2;
    }
    if (t >= 3) std::swap(corner[1], corner[2]); // odd permutations are left-handed
    for (const auto& n : corner) block.nodes.push_back(p(n[0], n[1], n[2]));
    for (const auto& e : edges) {
      const auto &a = corner[static_cast<std::size_t>(e[0])], &b = corner[static_cast<std::size_t>(e[1])];
      block.nodes.push_back(p((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2));
    }
  }
}

/// A box of n[0] x n[1] x n[2] cells of hexahedra or tetrahedra on [0, 1]^3 mapped by `map`. Groups: "body";
/// "skin", its surface in `skin` elements with outward normals; the points "boundary" of the surface.
inline mesh::Mesh box(ElementKind kind, ElementKind skin, const std::array<int, 3>& n,
                      const std::function<Eigen::Vector3d(double, double, double)>& map) {
  mesh::Mesh mesh;
  const std::array<int, 3> m = {2 * n[0], 2 * n[1], 2 * n[2]};
  const auto id = [&](int i, int j, int k) {
    return static_cast<std::int32_t>((k * (m[1] + 1) + j) * (m[0] + 1) + i);
  };
  ElementBlock body{"body", kind, {}}, surface{"skin", skin, {}},
      boundary{"boundary", ElementKind::point1, {}};
  for (int k = 0; k <= m[2]; ++k)
    for (int j = 0; j <= m[1]; ++j)
      for (int i = 0; i <= m[0]; ++i) {
        const Eigen::Vector3d X =
            map(static_cast<double>(i) / m[0], static_cast<double>(j) / m[1], static_cast<double>(k) / m[2]);
        mesh.points.insert(mesh.points.end(), {X(0), X(1), X(2)});
        if (i % m[0] == 0 || j % m[1] == 0 || k % m[2] == 0) boundary.nodes.push_back(id(i, j, k));
      }
  for (int k = 0; k < m[2]; k += 2)
    for (int j = 0; j < m[1]; j += 2)
      for (int i = 0; i < m[0]; i += 2)
        fill_cell(body, [&](int a, int b, int c) { return id(i + a, j + b, k + c); });
  // On the side x_axis = 0 or 1 the other two axes follow cyclically; the order turns on the side 0.
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const bool far : {false, true}) {
      const std::size_t u = (axis + (far ? 1 : 2)) % 3, v = (axis + (far ? 2 : 1)) % 3;
      for (int b = 0; b < m[v]; b += 2)
        for (int a = 0; a < m[u]; a += 2) {
          std::array<std::array<std::int32_t, 3>, 3> p{};
          for (int s = 0; s < 3; ++s)
            for (int r = 0; r < 3; ++r) {
              std::array<int, 3> at{};
              at[axis] = far ? m[axis] : 0;
              at[u] = a + r;
              at[v] = b + s;
              p[static_cast<std::size_t>(s)][static_cast<std::size_t>(r)] = id(at[0], at[1], at[2]);
            }
          fill_patch(surface, p);
        }
    }
  mesh.blocks = {std::move(body), std::move(surface), std::move(boundary)};
  return mesh;
}

} // namespace drogue::structure::test
