// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/cells.hpp"

#include <algorithm>

#include "mesh_mover/pseudo_solid.hpp"

namespace drogue::mesh_mover {
namespace {

std::vector<std::int32_t> all_of(const mesh::Mesh& mesh, mesh::ElementKind kind) {
  std::vector<std::int32_t> nodes;
  for (const auto& block : mesh.blocks)
    if (block.kind == kind) nodes.insert(nodes.end(), block.nodes.begin(), block.nodes.end());
  return nodes;
}

bool in_one_plane(const mesh::Mesh& mesh, std::span<const std::int32_t> nodes) {
  const auto z = [&](std::int32_t node) { return mesh.points[3 * static_cast<std::size_t>(node) + 2]; };
  return std::all_of(nodes.begin(), nodes.end(), [&](std::int32_t node) { return z(node) == z(nodes[0]); });
}

bool all_clockwise(const mesh::Mesh& mesh, const Cells& cells) {
  for (std::size_t e = 0; e < cells.count(); ++e)
    if (!(simplex_jacobian<2>(mesh.points, cells.cell(e)) < 0)) return false;
  return true;
}

} // namespace

Cells cells_of(const mesh::Mesh& mesh) {
  Cells cells{3, all_of(mesh, mesh::ElementKind::tet4)};
  if (!cells.nodes.empty()) return cells;
  auto triangles = all_of(mesh, mesh::ElementKind::tri3);
  if (triangles.empty() || !in_one_plane(mesh, triangles)) return cells;
  cells = {2, std::move(triangles)};
  if (all_clockwise(mesh, cells))
    for (std::size_t k = 0; k < cells.nodes.size(); k += 3) std::swap(cells.nodes[k + 1], cells.nodes[k + 2]);
  return cells;
}

std::vector<std::int32_t> with_cells_on_the_left(std::vector<std::int32_t> lines, const Cells& cells) {
  std::vector<std::array<std::int32_t, 2>> edges; // anticlockwise: the cell lies on the left
  for (std::size_t e = 0; e < cells.count(); ++e)
    for (std::size_t a = 0; a < 3; ++a) edges.push_back({cells.cell(e)[a], cells.cell(e)[(a + 1) % 3]});
  std::sort(edges.begin(), edges.end());
  const auto has_cell = [&](std::int32_t a, std::int32_t b) {
    return std::binary_search(edges.begin(), edges.end(), std::array{a, b});
  };
  for (std::size_t k = 0; k < lines.size(); k += 2)
    if (!has_cell(lines[k], lines[k + 1]) && has_cell(lines[k + 1], lines[k]))
      std::swap(lines[k], lines[k + 1]);
  return lines;
}

std::array<double, 3> centroid(std::span<const double> points, std::span<const std::int32_t> nodes) noexcept {
  std::array<double, 3> c{};
  for (const std::int32_t node : nodes)
    for (std::size_t i = 0; i < 3; ++i)
      c[i] += points[3 * static_cast<std::size_t>(node) + i] / static_cast<double>(nodes.size());
  return c;
}

} // namespace drogue::mesh_mover
