// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace drogue::structure {

/// Largest and smallest principal second Piola-Kirchhoff stress at a point, and their axes e carried into the
/// current configuration: unit vectors along F e, zero where F e is.
struct PrincipalStress {
  double largest = 0;
  double smallest = 0;
  Eigen::Vector3d largest_direction = Eigen::Vector3d::Zero();
  Eigen::Vector3d smallest_direction = Eigen::Vector3d::Zero();
};

} // namespace drogue::structure
