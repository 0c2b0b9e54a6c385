// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "common/la_krylov/node_graph.hpp"
#include "common/mesh/mesh.hpp"

namespace drogue::fluid {

/// A triangle of a boundary: nodes in the order that makes the normal point out of the fluid.
struct BoundaryFace {
  std::array<std::int32_t, 3> nodes{};
  std::int32_t tet = 0;
  std::int32_t boundary = 0; ///< index into FluidMesh::boundaries
};

/// The fluid's mesh as the solver uses it: nodes in reverse Cuthill-McKee order, tetrahedra with positive
/// volume in the order of their nodes. Files and the coupler keep the file's node order; the two functions
/// translate.
struct FluidMesh {
  mesh::Mesh file;
  std::string hash;
  std::vector<std::int32_t> to_file; ///< node -> node of the file
  std::vector<std::int32_t> from_file;
  std::vector<double> points;     ///< {n, 3}
  std::vector<std::int32_t> tets; ///< {m, 4}
  std::vector<std::string> boundaries;
  std::vector<BoundaryFace> faces;
  la::NodeGraph graph;

  /// Errors (ErrorKind::config): no tetrahedra, an element kind that the solver does not know, a flat
  /// tetrahedron, a boundary triangle that is not a face of exactly one tetrahedron, an outer face without a
  /// boundary group.
  [[nodiscard]] static Result<FluidMesh> create(mesh::Mesh mesh);

  [[nodiscard]] std::int32_t node_count() const { return static_cast<std::int32_t>(to_file.size()); }
  [[nodiscard]] std::int32_t tet_count() const { return static_cast<std::int32_t>(tets.size() / 4); }
  /// Nodal values {n, components} from the file's order to the solver's, and back.
  [[nodiscard]] std::vector<double> reordered_from_file(std::span<const double> values, int components) const;
  [[nodiscard]] std::vector<double> reordered_to_file(std::span<const double> values, int components) const;
  /// Sorted, unique nodes of the faces of some boundaries.
  [[nodiscard]] std::vector<std::int32_t> nodes_of(std::span<const std::int32_t> boundary_indices) const;
};

/// Area times outward unit normal of a face on the given points {n, 3}.
[[nodiscard]] std::array<double, 3> area_vector(const BoundaryFace& face, std::span<const double> points);

/// Smallest ratio of a tetrahedron's volume on `points` to that in the file; not positive: inverted.
[[nodiscard]] double smallest_volume_ratio(const FluidMesh& mesh, std::span<const double> points);

} // namespace drogue::fluid
