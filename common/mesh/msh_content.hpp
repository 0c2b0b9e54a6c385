// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/result.hpp"
#include "common/mesh/mesh.hpp"

namespace drogue::mesh {

/// What a mesh file holds, by the numbers (tags) it gives to nodes, elements, entities and physical groups.
struct MshContent {
  /// A dimension and the tag of a geometric entity or of a physical group.
  using DimTag = std::pair<int, int>;

  /// Elements of one kind in one geometric entity.
  struct Elements {
    ElementKind kind = ElementKind::point1;
    int entity = 0;
    std::vector<int> groups; ///< tags of their physical groups
    std::vector<std::uint64_t> tags;
    std::vector<std::uint64_t> nodes; ///< tags, shape {elements, nodes_per_element(kind)}
  };
  /// Values on nodes, of the last step in the file.
  struct Field {
    int step = 0, components = 1;
    std::vector<std::uint64_t> nodes;
    std::vector<double> values; ///< shape {nodes, components}
  };

  std::vector<std::uint64_t> node_tags;
  std::vector<double> points; ///< shape {nodes, 3}
  std::vector<Elements> elements;
  std::map<DimTag, std::string> group_names;
  std::map<std::string, Field> fields;
};

/// The kinds that Drogue knows, for messages.
inline constexpr const char* known_kinds =
    "points, lines of 2 or 3 nodes, triangles of 3 or 6, quadrangles of 4 or 9, tetrahedra of 4 or 10, "
    "hexahedra of 27";

/// Kind of an element of Gmsh's type; nothing when Drogue does not know it.
[[nodiscard]] std::optional<ElementKind> kind_of(int gmsh_type);

/// What every .msh file begins with, whatever it is called.
inline constexpr std::string_view msh_start = "$MeshFormat";

/// Reads the content of a .msh file: 2 to 2.2 and 4.1, in text or binary form. Sections that are not needed
/// are left out. Everything is checked before it is used: sizes and counts against what is left of the file,
/// kinds of elements, the dimension of their entity. Whether the nodes are there is not.
///
/// Errors (ErrorKind::config): what is wrong, in which line or at which byte, and what would be right.
[[nodiscard]] Result<MshContent> parse_msh(const std::string& file, std::string content);

/// Reads a file of another format with Gmsh.
[[nodiscard]] Result<MshContent> read_by_gmsh(const std::string& file);

} // namespace drogue::mesh
