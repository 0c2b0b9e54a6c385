// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/base/result.hpp"
#include "common/fem/shape.hpp"
#include "common/mesh/mesh.hpp"

namespace drogue::projection {

/// One side of the interface: a mesh of T3, T6, Q4 and Q9 in any mixture.
struct Surface {
  /// For messages: "fluid", "structure".
  std::string name;
  /// {n, 3}: positions at the start [length].
  std::vector<double> points;
  /// {n, 3}: positions without stress, whose area is the weight of the least squares; empty: points.
  std::vector<double> reference;
  /// {n, 3}: coordinates in which the two surfaces are matched, on a canopy the flat cloth pattern; empty:
  /// reference. Layers that touch in space have different material coordinates; the two fluid sides of a
  /// canopy have the same.
  std::vector<double> material;
  /// Connectivity of the elements, indices into the arrays above.
  std::vector<mesh::ElementBlock> blocks;

  [[nodiscard]] std::size_t node_count() const { return points.size() / 3; }
};

/// Elements of all blocks, one after the other.
class Elements {
 public:
  Elements() = default;
  explicit Elements(const Surface& surface);
  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(kinds_.size()); }
  [[nodiscard]] mesh::ElementKind kind(std::int32_t e) const { return kinds_[static_cast<std::size_t>(e)]; }
  [[nodiscard]] std::span<const std::int32_t> nodes(std::int32_t e) const {
    const auto i = static_cast<std::size_t>(e);
    return {nodes_.data() + offsets_[i], static_cast<std::size_t>(offsets_[i + 1] - offsets_[i])};
  }

 private:
  std::vector<mesh::ElementKind> kinds_;
  std::vector<std::int64_t> offsets_{0};
  std::vector<std::int32_t> nodes_;
};

/// Fills empty `reference` and `material`, and checks the surface.
/// Errors (ErrorKind::config): no elements, volume elements, sizes or indices that do not fit, values that
/// are not finite, a node without an element, an element without area in reference or material coordinates.
[[nodiscard]] Result<void> complete(Surface& surface);

/// Coordinates of an element's nodes, one a column; columns beyond `nodes` are zero.
using NodeMatrix = Eigen::Matrix<double, 3, fem::max_surface_nodes>;
[[nodiscard]] NodeMatrix gather(std::span<const std::int32_t> nodes,
                                std::span<const double> coordinates) noexcept;

/// Position, tangents and area vector x_xi cross x_eta at one point of an element.
[[nodiscard]] inline Eigen::Vector3d combine(const std::array<double, fem::max_surface_nodes>& N, int nodes,
                                             const NodeMatrix& X) noexcept {
  Eigen::Vector3d x = N[0] * X.col(0);
  for (int a = 1; a < nodes; ++a) x += N[static_cast<std::size_t>(a)] * X.col(a);
  return x;
}
[[nodiscard]] inline Eigen::Vector3d area_vector(const fem::SurfaceShape& s, const NodeMatrix& X) noexcept {
  return combine(s.dN_dxi, s.nodes, X).cross(combine(s.dN_deta, s.nodes, X));
}

/// Area of the parent domain times the Jacobian at the centre.
[[nodiscard]] double rough_area(mesh::ElementKind kind, const NodeMatrix& X) noexcept;

/// Diagonal of the bounding box of {n, 3} coordinates.
[[nodiscard]] double extent(std::span<const double> coordinates) noexcept;

/// Gives nodes at the same place (within `tolerance`) the same number: {n}, numbers 0, 1, ... in the order of
/// their first node.
struct Merged {
  std::vector<std::int32_t> group;
  std::int32_t count = 0;
};
[[nodiscard]] Merged merge_coincident(std::span<const double> coordinates, double tolerance);

} // namespace drogue::projection
