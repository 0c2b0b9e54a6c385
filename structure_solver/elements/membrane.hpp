// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>

#include <Eigen/Dense>

#include "structure_solver/elements/element.hpp"
#include "structure_solver/elements/surface_rule.hpp"

namespace drogue::structure {

/// Plane stress, St. Venant-Kirchhoff: S = E/(1-nu^2) ((1-nu) E + nu tr(E) I) + S_0 I.
struct MembraneMaterial {
  double thickness = 0;      ///< h [length], constant
  double density = 0;        ///< rho_0 [mass per volume]
  double youngs_modulus = 0; ///< E [stress]
  double poisson_ratio = 0;  ///< nu
  double prestress = 0;      ///< S_0 [stress], isotropic, in the reference configuration
};

/// Principal second Piola-Kirchhoff stresses at a point.
struct PrincipalStress {
  double largest = 0;
  double smallest = 0;
};

/// Membrane without bending stiffness, total Lagrangian [stein2001, eq. (3)].
///
/// Weak form: for all w,  int_A0 h S : dE(w) dA = external work,  E = 1/2 (F^T F - I) in the tangent plane,
/// F = [f_1 f_2] = dx/dX (3 x 2). With the shape functions' derivatives in the tangent plane, b_a = dN_a/dX:
///   force on node a     int h (f_1 S_1. + f_2 S_2.) b_a dA
///   tangent (a, b)      int h (B_a^T C B_b + (b_a . S b_b) I) dA
/// The tangent is exact and symmetric. Constant-thickness form: h is the reference thickness.
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
    Eigen::Matrix<double, 3, 2> F;
    Eigen::Vector3d strain;
    Eigen::Vector3d stress; ///< S_11, S_22, S_12
  };
  [[nodiscard]] static PointState point_state(const Reference& ref, const Material& m, const Positions& x,
                                              std::size_t q) noexcept {
    PointState s;
    s.F = x * ref.gradient[q].transpose();
    s.strain << 0.5 * (s.F.col(0).squaredNorm() - 1), 0.5 * (s.F.col(1).squaredNorm() - 1),
        s.F.col(0).dot(s.F.col(1));
    const double c = m.youngs_modulus / (1 - m.poisson_ratio * m.poisson_ratio);
    s.stress << c * (s.strain(0) + m.poisson_ratio * s.strain(1)) + m.prestress,
        c * (s.strain(1) + m.poisson_ratio * s.strain(0)) + m.prestress,
        c * 0.5 * (1 - m.poisson_ratio) * s.strain(2);
    return s;
  }

  static void evaluate(const Reference& ref, const Material& m, const Positions& x, bool tangent,
                       Response<nodes>& out) noexcept {
    out.clear(tangent);
    const double nu = m.poisson_ratio, c = m.youngs_modulus / (1 - nu * nu);
    for (std::size_t q = 0; q < points; ++q) {
      const PointState s = point_state(ref, m, x, q);
      const auto& B = ref.gradient[q];
      const double w = m.thickness * ref.area[q];
      Eigen::Matrix2d S;
      S << s.stress(0), s.stress(2), s.stress(2), s.stress(1);
      out.force.noalias() += (w * s.F * S) * B;
      const Eigen::Vector3d prestress(m.prestress, m.prestress, 0);
      out.energy += 0.5 * w * s.strain.dot(s.stress + prestress);
      if (!tangent) continue;
      const Eigen::Vector3d f1 = s.F.col(0), f2 = s.F.col(1);
      for (int b = 0; b < nodes; ++b) {
        const Eigen::Vector3d e1 = f1 * B(0, b), e2 = f2 * B(1, b), e3 = f1 * B(1, b) + f2 * B(0, b);
        const Eigen::Vector3d s1 = w * c * (e1 + nu * e2), s2 = w * c * (e2 + nu * e1);
        const Eigen::Vector3d s3 = w * c * 0.5 * (1 - nu) * e3;
        const Eigen::Vector2d Sb = w * (S * B.col(b));
        for (int a = 0; a < nodes; ++a) {
          const Eigen::Vector3d c3 = f1 * B(1, a) + f2 * B(0, a);
          Eigen::Matrix3d K =
              (B(0, a) * f1) * s1.transpose() + (B(1, a) * f2) * s2.transpose() + c3 * s3.transpose();
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
};

} // namespace drogue::structure
