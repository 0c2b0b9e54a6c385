// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>

#include <Eigen/Dense>

#include "structure_solver/elements/element.hpp"
#include "structure_solver/elements/plane_stress.hpp"
#include "structure_solver/elements/surface_rule.hpp"

namespace drogue::structure {

/// Membrane without bending stiffness, total Lagrangian [stein2001, eq. (3)].
///
/// Weak form: for all w,  int_A0 h S : dE(w) dA = external work,  E = 1/2 (F^T F - I) in the tangent plane,
/// F = [f_1 f_2] = dx/dX (3 x 2). With the shape functions' derivatives in the tangent plane, b_a = dN_a/dX:
///   force on node a     int h (f_1 S_1. + f_2 S_2.) b_a dA
///   tangent (a, b)      int h (B_a^T C B_b + (b_a . S b_b) I) dA,  C = dS/dE
/// S and C come from the plane-stress law. The tangent is symmetric, and exact up to the slack stiffness of a
/// tension field. Constant-thickness form: h is the reference thickness.
template <mesh::ElementKind Kind>
struct Membrane {
  static constexpr mesh::ElementKind kind = Kind;
  static constexpr int nodes = SurfaceTraits<Kind>::nodes;
  static constexpr int points = SurfaceTraits<Kind>::points;
  using Positions = typename Response<nodes>::Positions;
  using NodalMass = Eigen::Matrix<double, nodes, 1>;
  using Material = MembraneMaterial;

  struct Reference {
    /// Rows: dN/dX_1, dN/dX_2 in an orthonormal frame of the tangent plane [1/length].
    std::array<Eigen::Matrix<double, 2, nodes>, points> gradient;
    /// Quadrature weight times area [area].
    std::array<double, points> area;
    NodalMass nodal_area;
  };

  /// @param X reference positions. A degenerate element has a non-positive or non-finite `area`.
  [[nodiscard]] static Reference reference(const Positions& X) {
    Reference ref;
    ref.nodal_area.setZero();
    const auto& rule = surface_rule<Kind>();
    for (std::size_t q = 0; q < points; ++q) {
      const auto& point = rule.points[q];
      const Eigen::Matrix<double, 3, 2> G = X * point.dN;
      const Eigen::Vector3d normal = G.col(0).cross(G.col(1));
      const Eigen::Vector3d t1 = G.col(0).normalized(), t2 = normal.normalized().cross(t1);
      Eigen::Matrix2d J; // J(i, j) = dX_j / dxi_i
      J << G.col(0).dot(t1), G.col(0).dot(t2), G.col(1).dot(t1), G.col(1).dot(t2);
      ref.gradient[q] = J.inverse() * point.dN.transpose();
      ref.area[q] = normal.norm() * point.weight;
      ref.nodal_area += point.N * ref.area[q];
    }
    return ref;
  }

  /// Strain and stress at a quadrature point; shear strain is the engineering one, gamma = 2 E_12.
  struct PointState {
    Eigen::Vector3d strain;
    Eigen::Vector3d stress; ///< S_11, S_22, S_12
    WrinkleState wrinkle_state;
  };
  [[nodiscard]] static PointState point_state(const Reference& ref, const Material& m, const Positions& x,
                                              std::size_t q) noexcept {
    const PlaneStressLaw law(m);
    const Eigen::Vector3d E = green_strain(x * ref.gradient[q].transpose());
    return {E, law.stress(E).S, law.state(E)};
  }

  static void evaluate(const Reference& ref, const Material& m, const Positions& x, bool tangent,
                       Response<nodes>& out) noexcept {
    out.clear(tangent);
    const PlaneStressLaw law(m);
    for (std::size_t q = 0; q < points; ++q) {
      const auto& B = ref.gradient[q];
      const Eigen::Matrix<double, 3, 2> F = x * B.transpose();
      const double w = m.thickness * ref.area[q];
      Eigen::Matrix3d C;
      double geometric_tension = 0;
      const PlaneStress at =
          tangent ? law.stress(green_strain(F), C, geometric_tension) : law.stress(green_strain(F));
      Eigen::Matrix2d S;
      S << at.S(0), at.S(2), at.S(2), at.S(1);
      out.force.noalias() += (w * F * S) * B;
      out.energy += w * at.energy;
      if (!tangent) continue;
      S.diagonal().array() += geometric_tension;
      for (int b = 0; b < nodes; ++b) {
        const Eigen::Matrix3d CB = w * strain_gradient(F, B, b) * C; // column i: h dA C_i. B_b
        const Eigen::Vector2d Sb = w * (S * B.col(b));
        for (int a = 0; a < nodes; ++a) {
          Eigen::Matrix3d K = strain_gradient(F, B, a) * CB.transpose();
          K.diagonal().array() += B.col(a).dot(Sb);
          out.tangent.template block<3, 3>(3 * a, 3 * b) += K;
        }
      }
    }
  }

  /// Row sums of the consistent mass: positive on both kinds.
  [[nodiscard]] static NodalMass lumped_mass(const Reference& ref, const Material& m) noexcept {
    return m.density * m.thickness * ref.nodal_area;
  }

  [[nodiscard]] static PrincipalStress principal_stress(const PointState& s) noexcept {
    const double mean = 0.5 * (s.stress(0) + s.stress(1));
    const double radius = std::hypot(0.5 * (s.stress(0) - s.stress(1)), s.stress(2));
    return {mean + radius, mean - radius};
  }

 private:
  /// E_11, E_22, 2 E_12
  [[nodiscard]] static Eigen::Vector3d green_strain(const Eigen::Matrix<double, 3, 2>& F) noexcept {
    return {0.5 * (F.col(0).squaredNorm() - 1), 0.5 * (F.col(1).squaredNorm() - 1), F.col(0).dot(F.col(1))};
  }

  /// Columns: dE_11/dx_a, dE_22/dx_a, 2 dE_12/dx_a [1/length].
  [[nodiscard]] static Eigen::Matrix3d strain_gradient(const Eigen::Matrix<double, 3, 2>& F,
                                                       const Eigen::Matrix<double, 2, nodes>& B,
                                                       int a) noexcept {
    Eigen::Matrix3d D;
    D << F.col(0) * B(0, a), F.col(1) * B(1, a), F.col(0) * B(1, a) + F.col(1) * B(0, a);
    return D;
  }
};

} // namespace drogue::structure
