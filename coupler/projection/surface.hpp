// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "coupler/projection/element.hpp"

namespace drogue::projection {

/// One side of the interface: a mesh of T3, T6, Q4 and Q9 in any mixture, or, in a plane problem, of lines
/// with two and three nodes in one plane z = const; then areas are lengths and forces are per unit depth.
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
  /// 1: lines, 2: faces. @pre there are elements
  [[nodiscard]] int dimension() const { return mesh::dimension(blocks.front().kind); }
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
/// Errors (ErrorKind::config): no elements, volume elements, lines beside faces or outside a plane z = const,
/// sizes or indices that do not fit, values that are not finite, a node without an element, an element
/// without area in reference or material coordinates.
[[nodiscard]] Result<void> complete(Surface& surface);

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
