// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesh_mover/coarse_space.hpp"
#include "mesh_mover/settings.hpp"

namespace drogue::mesh_mover {

/// What the boundaries do at one instant.
struct BoundaryInput {
  /// t_{n+1}, for the displacement expressions.
  double time = 0;
  /// Since the start, of the nodes in interface_nodes(), {n, 3} [length]; empty: the expressions of the
  /// interface boundaries hold.
  std::span<const double> interface_displacement;
  /// Since the start, of the translated boundaries [length].
  std::array<double, 3> translation{};
};

/// Which components of which nodes are given, and by what. Where boundaries meet, a node follows the
/// strongest: interface, displacement, fixed or translated, sliding; among equals the one that stands first
/// in the config. Two sliding planes combine.
class BoundaryMotion {
 public:
  /// Errors (ErrorKind::config): a direction in which no node of the mesh is held.
  /// @param dimension 2: the third component of all nodes is given, and zero
  [[nodiscard]] static Result<BoundaryMotion> create(const mesh::Mesh& mesh, int dimension,
                                                     std::vector<Boundary> boundaries);

  /// Bit i: component i of the node is given. Shape {nodes}.
  [[nodiscard]] const Mask& given() const { return given_; }
  /// Sorted, unique nodes of all interface boundaries.
  [[nodiscard]] const std::vector<std::int32_t>& interface_nodes() const { return interface_nodes_; }

  [[nodiscard]] const std::vector<Boundary>& boundaries() const { return boundaries_; }
  /// The nodes that boundary k governs alone.
  [[nodiscard]] const std::vector<std::int32_t>& owned_nodes(std::size_t k) const { return owned_[k]; }
  /// The nodes of all boundaries with a displacement, sorted.
  [[nodiscard]] std::vector<std::int32_t> displaced_nodes() const;

  /// Writes the given entries of the displacement since the start; leaves the others alone.
  /// `initial_points` and `u` {nodes, 3}.
  void evaluate(const BoundaryInput& input, std::span<const double> initial_points,
                std::span<double> u) const;

 private:
  explicit BoundaryMotion(std::vector<Boundary> boundaries) : boundaries_(std::move(boundaries)) {}
  void assign(const mesh::Mesh& mesh, int dimension);

  std::vector<Boundary> boundaries_;
  std::vector<std::vector<std::int32_t>> owned_; // nodes a boundary governs alone, {boundaries}
  std::vector<std::int32_t> interface_nodes_;
  Mask given_;
};

} // namespace drogue::mesh_mover
