// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coupler/projection/closest_point.hpp"

namespace drogue::projection {

struct Located {
  std::int32_t element = -1;
  ClosestPoint point;
};

/// Bounding-volume tree over the elements of a surface: O(n log n) to build, about O(log n) a query.
class SurfaceTree {
 public:
  /// @param coordinates {n, 3}, in which distances are measured; both arguments must outlive the tree
  SurfaceTree(const Elements& elements, std::span<const double> coordinates);

  /// The element closest to p. `hint` (an element, or -1) is tried first: give the last answer for a near
  /// point.
  [[nodiscard]] Located closest(const Eigen::Vector3d& p, std::int32_t hint = -1) const noexcept;
  /// Number of elements on which p has a foot within `distance`: the layers that lie on one another there.
  [[nodiscard]] int layers(const Eigen::Vector3d& p, double distance) const noexcept;

 private:
  struct Node {
    Eigen::Vector3d low, high;
    std::int32_t first = 0; ///< leaf: first entry of order_; branch: the right child (the left one follows)
    std::int32_t count = 0; ///< 0: branch
  };
  std::int32_t build(std::int32_t first, std::int32_t last, std::span<const Node> boxes);
  [[nodiscard]] static double box_distance2(const Node& node, const Eigen::Vector3d& p) noexcept;

  [[nodiscard]] ClosestPoint on_element(std::int32_t e, const Eigen::Vector3d& p) const noexcept;

  const Elements* elements_;
  std::span<const double> coordinates_;
  std::vector<std::int32_t> order_;
  std::vector<Node> nodes_;
};

} // namespace drogue::projection
