// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>

#include <Eigen/Dense>

#include "structure_solver/elements/element.hpp"
#include "structure_solver/elements/element_rule.hpp"
#include "structure_solver/elements/plane_stress.hpp"
#include "structure_solver/elements/principal_stress.hpp"

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
  static constexpr int nodes = ElementTraits<Kind>::nodes;
  static constexpr int points = ElementTraits<Kind>::points;
  static constexpr const char* irregular = "is degenerate: its area vanishes or its sides cross";
  using Positions = typename Response<nodes>::Positions;
  using NodalMass = Eigen::Matrix<double, nodes, 1>;
  using Material = MembraneMaterial;

  struct Reference {
    /// Rows: dN/dX_1, dN/dX_2 in an orthonormal frame of the tangent plane [1/length].
    std::array<Eigen::Matrix<double, 2, nodes>, points> gradient;
    /// Quadrature weight times area [area].
    std::array<double, points> measure;
  };

  /// @param X reference positions; check them with regular()
  [[nodiscard]] static Reference reference(const Positions& X) {
    Reference ref;
    const auto& rule = element_rule<Kind>();
    for (std::size_t q = 0; q < points; ++q) {
      const auto& point = rule.points[q];
      const Eigen::Matrix<double, 3, 2> G = X.lazyProduct(point.dN);
      const Eigen::Vector3d normal = G.col(0).cross(G.col(1));
      const Eigen::Vector3d t1 = G.col(0).normalized(), t2 = normal.normalized().cross(t1);
      Eigen::Matrix2d J; // J(i, j) = dX_j / dxi_i
      J << G.col(0).dot(t1), G.col(0).dot(t2), G.col(1).dot(t1), G.col(1).dot(t2);
      ref.gradient[q] = J.inverse() * point.dN.transpose();
      ref.measure[q] = normal.norm() * point.weight;
    }
    return ref;
  }

  /// False when an area vanishes, to rounding, at a quadrature point, or the normal turns by more than a
  /// right angle within the element.
  [[nodiscard]] static bool regular(const Positions& X, const Reference&) {
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    for (const auto& point : element_rule<Kind>().points) {
      const Eigen::Matrix<double, 3, 2> G = X.lazyProduct(point.dN);
      const Eigen::Vector3d normal = G.col(0).cross(G.col(1));
      if (first.isZero(0)) first = normal;
      if (!(normal.norm() > rounding * G.col(0).norm() * G.col(1).norm()) || !(normal.dot(first) > 0))
        return false;
    }
    return true;
  }

  /// Strain and stress at a quadrature point; shear strain is the engineering one, gamma = 2 E_12.
  struct PointState {
    Eigen::Vector3d strain;
    Eigen::Vector3d stress; ///< S_11, S_22, S_12
    WrinkleState wrinkle_state;
    Eigen::Matrix<double, 3, 2> F = Eigen::Matrix<double, 3, 2>::Zero();
  };
  [[nodiscard]] static PointState point_state(const Reference& ref, const Material& m, const Positions& x,
                                              std::size_t q) noexcept {
    const PlaneStressLaw law(m);
    const Eigen::Matrix<double, 3, 2> F = x.lazyProduct(ref.gradient[q].transpose());
    const Eigen::Vector3d E = green_strain(F);
    return {E, law.stress(E).S, law.state(E), F};
  }

  static void evaluate(const Reference& ref, const Material& m, const Positions& x, bool tangent,
                       Response<nodes>& out) noexcept {
    out.clear(tangent);
    const PlaneStressLaw law(m);
    Eigen::Matrix<double, nodes, nodes> geometric = Eigen::Matrix<double, nodes, nodes>::Zero();
    for (std::size_t q = 0; q < points; ++q) {
      const auto& B = ref.gradient[q];
      const Eigen::Matrix<double, 3, 2> F = x.lazyProduct(B.transpose());
      const double w = m.thickness * ref.measure[q];
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
      const Eigen::Matrix<double, 2, nodes> SB = w * S * B;
      geometric +=
          B.transpose().lazyProduct(SB); // lazyProduct: in line, without the set-up of a large product
      const StrainGradients D = strain_gradients(F, B), CD = w * D.lazyProduct(C);
      for (int b = 0; b < nodes; ++b) {
        const int rows = 3 * (b + 1);
        out.tangent.template middleCols<3>(3 * b).topRows(rows) +=
            D.topRows(rows).lazyProduct(CD.template middleRows<3>(3 * b).transpose());
      }
    }
    if (tangent) complete(geometric, out);
  }

  [[nodiscard]] static NodalMass lumped_mass(const Reference& ref, const Material& m) noexcept {
    return m.density * m.thickness * lumped_measure<Kind>(ref.measure);
  }

  [[nodiscard]] static PrincipalStress principal_stress(const PointState& s) noexcept {
    const double mean = 0.5 * (s.stress(0) + s.stress(1));
    const double radius = std::hypot(0.5 * (s.stress(0) - s.stress(1)), s.stress(2));
    const double angle = 0.5 * std::atan2(2 * s.stress(2), s.stress(0) - s.stress(1));
    const Eigen::Vector2d e1(std::cos(angle), std::sin(angle)), e2(-e1(1), e1(0));
    return {mean + radius, mean - radius, (s.F * e1).normalized(), (s.F * e2).normalized()};
  }

 private:
  static constexpr double rounding = 1e-10;

  /// E_11, E_22, 2 E_12
  [[nodiscard]] static Eigen::Vector3d green_strain(const Eigen::Matrix<double, 3, 2>& F) noexcept {
    return {0.5 * (F.col(0).squaredNorm() - 1), 0.5 * (F.col(1).squaredNorm() - 1), F.col(0).dot(F.col(1))};
  }

  /// Columns: dE_11/dx, dE_22/dx, 2 dE_12/dx, x node by node [1/length].
  using StrainGradients = Eigen::Matrix<double, 3 * nodes, 3>;
  [[nodiscard]] static StrainGradients strain_gradients(const Eigen::Matrix<double, 3, 2>& F,
                                                        const Eigen::Matrix<double, 2, nodes>& B) noexcept {
    StrainGradients D;
    for (int a = 0; a < nodes; ++a)
      D.template middleRows<3>(3 * a) << F.col(0) * B(0, a), F.col(1) * B(1, a),
          F.col(0) * B(1, a) + F.col(1) * B(0, a);
    return D;
  }

  /// Adds the geometric part to the upper blocks of the tangent, and mirrors them.
  static void complete(const Eigen::Matrix<double, nodes, nodes>& geometric, Response<nodes>& out) noexcept {
    for (int b = 0; b < nodes; ++b)
      for (int a = 0; a <= b; ++a) {
        auto block = out.tangent.template block<3, 3>(3 * a, 3 * b);
        block.diagonal().array() += geometric(a, b);
        if (a != b) out.tangent.template block<3, 3>(3 * b, 3 * a) = block.transpose();
      }
  }
};

} // namespace drogue::structure
