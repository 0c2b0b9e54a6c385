// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cassert>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace drogue::mesh_mover {

/// The elements that fill the fluid's domain: triangles in two dimensions, tetrahedra in three.
struct Cells {
  int dimension = 3;
  /// Connectivity {m, dimension + 1}, in mesh order.
  std::vector<std::int32_t> nodes;

  [[nodiscard]] std::size_t nodes_per_cell() const noexcept {
    return static_cast<std::size_t>(dimension) + 1;
  }
  [[nodiscard]] std::size_t count() const noexcept { return nodes.size() / nodes_per_cell(); }
  [[nodiscard]] std::span<const std::int32_t> cell(std::size_t e) const noexcept {
    return {nodes.data() + nodes_per_cell() * e, nodes_per_cell()};
  }
  [[nodiscard]] const char* name() const noexcept { return dimension == 2 ? "triangle" : "tetrahedron"; }
  [[nodiscard]] const char* plural() const noexcept { return dimension == 2 ? "triangles" : "tetrahedra"; }
};

/// All tetrahedra of a mesh. A mesh without any, but with triangles in one plane z = const, is
/// two-dimensional: its triangles, turned round when all of them run clockwise. No cells when it is neither.
[[nodiscard]] Cells cells_of(const mesh::Mesh& mesh);

/// Lines {n, 2} of a two-dimensional mesh, turned where the only cell beside one lies on its right.
[[nodiscard]] std::vector<std::int32_t> with_cells_on_the_left(std::vector<std::int32_t> lines,
                                                               const Cells& cells);

/// Mean of the nodes' positions.
[[nodiscard]] std::array<double, 3> centroid(std::span<const double> points,
                                             std::span<const std::int32_t> nodes) noexcept;

/// Calls visit(std::integral_constant<int, D>{}) with D = dimension, so that kernels know it when compiled.
template <class Visit>
decltype(auto) with_dimension(int dimension, Visit&& visit) {
  assert(dimension == 2 || dimension == 3);
  if (dimension == 2) return visit(std::integral_constant<int, 2>{});
  return visit(std::integral_constant<int, 3>{});
}

} // namespace drogue::mesh_mover
