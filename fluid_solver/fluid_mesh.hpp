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

/// A triangle of a boundary, in two dimensions an edge: its nodes in the order that makes the normal point
/// out of the fluid.
struct BoundaryFace {
  std::array<std::int32_t, 3> corner{};
  std::size_t corners = 3;
  std::int32_t cell = 0;
  std::int32_t boundary = 0; ///< index into FluidMesh::boundaries

  [[nodiscard]] std::span<const std::int32_t> nodes() const { return {corner.data(), corners}; }
};

/// The fluid's mesh as the solver uses it: nodes in reverse Cuthill-McKee order, cells (tetrahedra, or the
/// triangles of a plane mesh) with positive volume in the order of their nodes. Files and the coupler keep
/// the file's node order; the two functions translate. Nodal vectors have three components in two dimensions
/// as well.
struct FluidMesh {
  mesh::Mesh file;
  std::string hash;
  int dimension = 3;
  std::vector<std::int32_t> to_file; ///< node -> node of the file
  std::vector<std::int32_t> from_file;
  std::vector<double> points;      ///< {n, 3}
  std::vector<std::int32_t> cells; ///< {m, dimension + 1}
  std::vector<std::string> boundaries;
  std::vector<BoundaryFace> faces;
  la::NodeGraph graph;

  /// Two-dimensional is a mesh of triangles in a plane z = const without a tetrahedron. Errors
  /// (ErrorKind::config): no cells, an element kind that the solver does not know, a flat cell, triangles out
  /// of the plane, a boundary face that is not a face of exactly one cell, an outer face without a boundary
  /// group.
  [[nodiscard]] static Result<FluidMesh> create(mesh::Mesh mesh);

  [[nodiscard]] std::int32_t node_count() const { return static_cast<std::int32_t>(to_file.size()); }
  [[nodiscard]] std::size_t cell_nodes() const { return static_cast<std::size_t>(dimension) + 1; }
  [[nodiscard]] std::int32_t cell_count() const {
    return static_cast<std::int32_t>(cells.size() / cell_nodes());
  }
  [[nodiscard]] std::span<const std::int32_t> cell(std::int32_t e) const {
    return {cells.data() + static_cast<std::size_t>(e) * cell_nodes(), cell_nodes()};
  }
  /// Nodal values {n, components} from the file's order to the solver's, and back.
  [[nodiscard]] std::vector<double> reordered_from_file(std::span<const double> values, int components) const;
  [[nodiscard]] std::vector<double> reordered_to_file(std::span<const double> values, int components) const;
  /// Sorted, unique nodes of the faces of some boundaries.
  [[nodiscard]] std::vector<std::int32_t> nodes_of(std::span<const std::int32_t> boundary_indices) const;
};

/// Area (of an edge: length) times outward unit normal of a face on the given points {n, 3}.
[[nodiscard]] std::array<double, 3> area_vector(const BoundaryFace& face, std::span<const double> points);

/// Gradients of the shape functions of a cell on `points` {n, 3} [1/length], zero in a third dimension that
/// is not there, and its signed volume.
struct CellGeometry {
  double gradient[4][3] = {};
  double volume = 0;
};
[[nodiscard]] CellGeometry cell_geometry(const FluidMesh& mesh, std::span<const double> points,
                                         std::int32_t cell);

/// Smallest ratio of a cell's volume on `points` to that in the file; not positive: inverted.
[[nodiscard]] double smallest_volume_ratio(const FluidMesh& mesh, std::span<const double> points);

} // namespace drogue::fluid
