// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace drogue::projection {

/// The corners of a triangle.
using Triangle = std::array<Eigen::Vector3d, 3>;

/// What of one triangle lies over another: the polygon common to both once the second is projected along the
/// first one's normal, and integrals of both triangles' shape functions over it.
struct Overlap {
  int corners = 0; ///< of the polygon; 0: none
  double area = 0; ///< of the polygon, in the parent coordinates of the first triangle, where that has 1/2
  /// 1 when both triangles go round in the same sense, -1 when they do not, 0 when the second one stands on
  /// its edge.
  int sense = 0;
  double gap = 0; ///< largest distance of the two along the normal, over the polygon
  std::array<double, 2> gap_at{};
  Eigen::Matrix3d
      cross;           ///< set where there are corners; (a, b): int N_a of the second times N_b of the first
  Eigen::Matrix3d own; ///< likewise; (a, b): int N_a N_b of the second
};

/// The first triangle with its plane.
class TriangleFrame {
 public:
  /// @pre the triangle has an area
  explicit TriangleFrame(const Triangle& corners) noexcept;
  /// int dxi deta over what `other` covers. Every triangle of a surface that is a graph over this plane takes
  /// its own part: their overlaps add up to the whole where they cover it.
  [[nodiscard]] Overlap overlap(const Triangle& other) const noexcept;
  /// Twice the area, and the unit normal.
  [[nodiscard]] double jacobian() const { return jacobian_; }
  [[nodiscard]] const Eigen::Vector3d& normal() const { return normal_; }

 private:
  Eigen::Vector3d origin_, dual_xi_, dual_eta_, normal_;
  double jacobian_ = 0;
};

} // namespace drogue::projection
