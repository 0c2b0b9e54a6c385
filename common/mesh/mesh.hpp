// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace drogue::mesh {

/// Element kinds, with Gmsh's node order: corners, then mid-edge nodes, then face centres, then the centre.
enum class ElementKind : std::uint8_t { point1, line2, line3, tri3, tri6, quad4, quad9, tet4, tet10, hex27 };

[[nodiscard]] int nodes_per_element(ElementKind kind);
[[nodiscard]] int dimension(ElementKind kind);
[[nodiscard]] std::string_view name(ElementKind kind);

/// Elements of one kind that belong to one named group.
struct ElementBlock {
  std::string group;
  ElementKind kind = ElementKind::tri3;
  /// Connectivity, shape {count, nodes_per_element(kind)}, indices into Mesh::points.
  std::vector<std::int32_t> nodes;

  [[nodiscard]] std::int32_t count() const {
    return static_cast<std::int32_t>(nodes.size()) / nodes_per_element(kind);
  }
  [[nodiscard]] std::span<const std::int32_t> element(std::int32_t e) const {
    const auto n = static_cast<std::size_t>(nodes_per_element(kind));
    return {nodes.data() + static_cast<std::size_t>(e) * n, n};
  }
};

/// Values on all nodes, shape {node count, components}; NaN where a node has none.
struct NodeField {
  int components = 1;
  std::vector<double> values;
};

/// A mesh in three-dimensional space: points, blocks of elements with group names, and fields on the nodes.
///
/// Fields that Drogue's own meshes carry: "material" (3 components), the coordinates in which two surfaces
/// are matched, on canopies the unfolded cloth pattern (s cos theta, s sin theta, 0).
struct Mesh {
  /// Coordinates, shape {node count, 3} [length].
  std::vector<double> points;
  std::vector<ElementBlock> blocks;
  std::map<std::string, NodeField> node_fields;

  [[nodiscard]] std::int32_t node_count() const { return static_cast<std::int32_t>(points.size() / 3); }
  /// Names of all groups, in the order of their first block.
  [[nodiscard]] std::vector<std::string> group_names() const;
  [[nodiscard]] bool has_group(std::string_view group) const;
  /// Sorted, unique nodes of a group; empty when there is no such group.
  [[nodiscard]] std::vector<std::int32_t> nodes_of(std::string_view group) const;
  /// Blocks of a group (one for each element kind in it).
  [[nodiscard]] std::vector<const ElementBlock*> blocks_of(std::string_view group) const;
};

/// Hash of points and connectivity: two processes that show the same hash hold the same mesh in the same
/// order.
[[nodiscard]] std::string hash(const Mesh& mesh);

} // namespace drogue::mesh
