// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Dense>

namespace drogue::structure {

/// Force of the air on a body that moves through it, F = 1/2 rho C_d A |w| w, with w the velocity of the air
/// relative to the body, and its derivatives. Symbols: k = 1/2 rho C_d A for a point, k = 1/2 rho C_d d for a
/// line of diameter d.
struct PointDrag {
  Eigen::Vector3d force;
  Eigen::Matrix3d by_wind; ///< dF/dw = k (|w| I + w w^T / |w|), symmetric

  [[nodiscard]] static PointDrag at(double k, const Eigen::Vector3d& w) noexcept {
    const double speed = w.norm();
    PointDrag drag{k * speed * w, k * speed * Eigen::Matrix3d::Identity()};
    if (speed > 0) drag.by_wind += (k / speed) * w * w.transpose();
    return drag;
  }
};

/// Drag of a straight line from x_1 to x_2, d = x_2 - x_1, l = |d|, t = d / l; w in its middle. Half of the
/// force acts on each node.
///   whole wind    F = k l |w| w
///   cross flow    F = k l |q| q with q = (I - t t^T) w: only the wind across the line counts
struct LineDrag {
  Eigen::Vector3d force;
  Eigen::Matrix3d by_wind; ///< dF/dw, symmetric
  Eigen::Matrix3d by_line; ///< dF/dd at fixed w

  [[nodiscard]] static LineDrag at(double k, bool cross_flow, const Eigen::Vector3d& d,
                                   const Eigen::Vector3d& w) noexcept {
    const double l = d.norm();
    if (!(l > 0)) return {Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
    const Eigen::Vector3d t = d / l;
    if (!cross_flow) {
      const PointDrag whole = PointDrag::at(k * l, w);
      return {whole.force, whole.by_wind, whole.force * t.transpose() / l};
    }
    const Eigen::Matrix3d P = Eigen::Matrix3d::Identity() - t * t.transpose();
    const Eigen::Vector3d q = P * w;
    const PointDrag across = PointDrag::at(k * l, q);
    // dq = P dw - (s P + t q^T) dd / l, with s = t . w
    const Eigen::Matrix3d q_by_line = -(t.dot(w) * P + t * q.transpose()) / l;
    return {across.force, P * across.by_wind * P,
            across.force * t.transpose() / l + across.by_wind * q_by_line};
  }
};

} // namespace drogue::structure
