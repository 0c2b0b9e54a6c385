// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Dense>

#include "structure_solver/elements/element.hpp"
#include "structure_solver/elements/element_rule.hpp"

namespace drogue::structure {

/// Pressure on the current surface: f_ext(w) = int p w . n da with n da = (g_1 x g_2) dxi deta, g_i =
/// dx/dxi_i. On an edge in the plane z = const, per unit depth, g_2 = e_z: n lies to the right of the edge's
/// direction, which is outward when the boundary is traversed with the body on the left.
///
/// Positive pressure pushes along the right-handed normal of the element's node order: it inflates when the
/// normals point out of the inflated shape. The kernel gives the share of the residual, -f_ext, and its exact
/// derivative, the load stiffness. That is not symmetric (its boundary part), hence an option of the
/// assembly.
template <mesh::ElementKind Kind>
struct FollowerPressure {
  static constexpr int nodes = ElementTraits<Kind>::nodes;
  static constexpr int dimension = ElementTraits<Kind>::dimension;
  using Positions = typename Response<nodes>::Positions;
  using NodalPressure = Eigen::Matrix<double, nodes, 1>;

  /// @param p pressure on the nodes [stress], interpolated with the shape functions
  static void evaluate(const ElementRule<Kind>& rule, const NodalPressure& p, const Positions& x,
                       bool tangent, Response<nodes>& out) noexcept {
    out.clear(tangent);
    for (const auto& point : rule.points) {
      Eigen::Matrix<double, 3, 2> g;
      g.template leftCols<dimension>() = x.lazyProduct(point.dN);
      if (dimension == 1) g.col(1) = Eigen::Vector3d::UnitZ();
      const double pw = p.dot(point.N) * point.weight;
      const Eigen::Vector3d load = pw * g.col(0).cross(g.col(1));
      out.force.noalias() -= load * point.N.transpose();
      if (!tangent) continue;
      const Eigen::Matrix3d cross1 = pw * skew(g.col(0)), cross2 = pw * skew(g.col(1));
      for (int b = 0; b < nodes; ++b) {
        // d(g_1 x g_2) = g_1 x dg_2 - g_2 x dg_1
        Eigen::Matrix3d D = -point.dN(b, 0) * cross2;
        if constexpr (dimension == 2) D += point.dN(b, 1) * cross1;
        for (int a = 0; a < nodes; ++a) out.tangent.template block<3, 3>(3 * a, 3 * b) -= point.N(a) * D;
      }
    }
  }

 private:
  [[nodiscard]] static Eigen::Matrix3d skew(const Eigen::Vector3d& v) noexcept {
    Eigen::Matrix3d m;
    m << 0, -v(2), v(1), v(2), 0, -v(0), -v(1), v(0), 0;
    return m;
  }
};

} // namespace drogue::structure
