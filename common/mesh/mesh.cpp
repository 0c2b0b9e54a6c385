// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/mesh.hpp"

#include <algorithm>

#include "common/base/hash.hpp"

namespace drogue::mesh {
namespace {

struct KindProperties {
  int nodes;
  int dimension;
  std::string_view name;
};

constexpr KindProperties properties(ElementKind kind) {
  switch (kind) {
  case ElementKind::point1:
    return {1, 0, "point"};
  case ElementKind::line2:
    return {2, 1, "2-node line"};
  case ElementKind::line3:
    return {3, 1, "3-node line"};
  case ElementKind::tri3:
    return {3, 2, "3-node triangle"};
  case ElementKind::tri6:
    return {6, 2, "6-node triangle"};
  case ElementKind::quad4:
    return {4, 2, "4-node quadrilateral"};
  case ElementKind::quad9:
    return {9, 2, "9-node quadrilateral"};
  case ElementKind::tet4:
    return {4, 3, "4-node tetrahedron"};
  case ElementKind::tet10:
    return {10, 3, "10-node tetrahedron"};
  case ElementKind::hex27:
    return {27, 3, "27-node hexahedron"};
  }
  return {0, 0, "unknown"};
}

} // namespace

int nodes_per_element(ElementKind kind) {
  return properties(kind).nodes;
}
int dimension(ElementKind kind) {
  return properties(kind).dimension;
}
std::string_view name(ElementKind kind) {
  return properties(kind).name;
}

std::vector<std::string> Mesh::group_names() const {
  std::vector<std::string> names;
  for (const ElementBlock& block : blocks)
    if (std::find(names.begin(), names.end(), block.group) == names.end()) names.push_back(block.group);
  return names;
}

bool Mesh::has_group(std::string_view group) const {
  return std::any_of(blocks.begin(), blocks.end(), [&](const ElementBlock& b) { return b.group == group; });
}

std::vector<std::int32_t> Mesh::nodes_of(std::string_view group) const {
  std::vector<std::int32_t> nodes;
  for (const ElementBlock& block : blocks)
    if (block.group == group) nodes.insert(nodes.end(), block.nodes.begin(), block.nodes.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

std::vector<const ElementBlock*> Mesh::blocks_of(std::string_view group) const {
  std::vector<const ElementBlock*> found;
  for (const ElementBlock& block : blocks)
    if (block.group == group) found.push_back(&block);
  return found;
}

std::string hash(const Mesh& mesh) {
  Hash h;
  h.add(std::span<const double>(mesh.points));
  for (const ElementBlock& block : mesh.blocks) {
    h.add(block.group);
    h.add(std::span<const std::int32_t>(block.nodes));
  }
  return h.text();
}

} // namespace drogue::mesh
