// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coupler/projection/surface.hpp"

namespace drogue::projection {

struct ClosestPoint {
  double xi = 0;
  double eta = 0;
  double distance2 = 0; ///< squared distance
  bool inside = false;  ///< the foot of a perpendicular, not a point that the element's edge holds back
};

/// Closest point of an element to p: Gauss-Newton on |x(xi, eta) - p|^2 from the nearest node, and along each
/// edge when that leaves the element; closed form on linear triangles. X: the nodes' coordinates.
[[nodiscard]] ClosestPoint closest_point(mesh::ElementKind kind, const NodeMatrix& X,
                                         const Eigen::Vector3d& p) noexcept;

/// The same on a linear triangle with its corners at a, b and c.
[[nodiscard]] ClosestPoint closest_point_of_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                                     const Eigen::Vector3d& c,
                                                     const Eigen::Vector3d& p) noexcept;

} // namespace drogue::projection
