// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include <Eigen/Dense>

#include "structure_solver/elements/element.hpp"
#include "structure_solver/elements/element_rule.hpp"
#include "structure_solver/elements/principal_stress.hpp"

namespace drogue::structure {

/// St. Venant-Kirchhoff: S = lambda tr(E) I + 2 mu E, lambda = E nu / ((1+nu)(1-2nu)), mu = E / (2 (1+nu)).
struct SolidMaterial {
  double density = 0;        ///< rho_0 [mass per volume]
  double youngs_modulus = 0; ///< E [stress]
  double poisson_ratio = 0;  ///< nu

  [[nodiscard]] double lambda() const noexcept {
    return youngs_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio));
  }
  [[nodiscard]] double mu() const noexcept { return 0.5 * youngs_modulus / (1 + poisson_ratio); }
};

/// Continuum, total Lagrangian, large displacements and rotations.
///
/// Weak form: for all w,  int_V0 S : dE(w) dV = external work,  E = 1/2 (F^T F - I),  F = dx/dX.
/// A volume in space (3 x 3), or a surface in the plane z = const in plane strain, per unit depth: then F, E,
/// S are 2 x 2, E_33 = 0 leaves the law as it stands, and nothing acts in z. With b_a = dN_a/dX:
///   force on node a   int F S b_a dV
///   tangent (a, b)    int (lambda (F b_a)(F b_b)^T + mu ((b_a . b_b) F F^T + (F b_b)(F b_a)^T)
///                          + (b_a . S b_b) I) dV
/// The tangent is exact and symmetric.
template <mesh::ElementKind Kind>
struct Solid {
  static constexpr mesh::ElementKind kind = Kind;
  static constexpr int nodes = ElementTraits<Kind>::nodes;
  static constexpr int points = ElementTraits<Kind>::points;
  static constexpr int dimension = ElementTraits<Kind>::dimension;
  static constexpr const char* irregular =
      "is degenerate or inverted: its Jacobian is not positive everywhere";
  using Positions = typename Response<nodes>::Positions;
  using NodalMass = Eigen::Matrix<double, nodes, 1>;
  using Material = SolidMaterial;
  using Tensor = Eigen::Matrix<double, dimension, dimension>;
  using Vector = Eigen::Matrix<double, dimension, 1>;

  struct Reference {
    /// Column a: dN_a/dX [1/length].
    std::array<Eigen::Matrix<double, dimension, nodes>, points> gradient;
    /// Quadrature weight times Jacobian: the volume of each point [volume].
    std::array<double, points> measure;
  };

  /// @param X reference positions; check them with regular()
  [[nodiscard]] static Reference reference(const Positions& X) {
    Reference ref;
    const auto& rule = element_rule<Kind>();
    for (std::size_t q = 0; q < points; ++q) {
      const auto& point = rule.points[q];
      const Tensor J = X.template topRows<dimension>().lazyProduct(point.dN); // J(i, j) = dX_i / dxi_j
      ref.gradient[q] = (point.dN * J.inverse()).transpose();
      ref.measure[q] = J.determinant() * point.weight;
    }
    return ref;
  }

  /// False when the Jacobian is not positive, to rounding, at a quadrature point.
  [[nodiscard]] static bool regular(const Positions& X, const Reference&) {
    for (const auto& point : element_rule<Kind>().points) {
      const Tensor J = X.template topRows<dimension>().lazyProduct(point.dN);
      if (!(J.determinant() > rounding * J.colwise().norm().prod())) return false;
    }
    return true;
  }

  /// Deformation gradient and second Piola-Kirchhoff stress at a quadrature point.
  struct PointState {
    Tensor F, E, S;
  };
  [[nodiscard]] static PointState point_state(const Reference& ref, const Material& m, const Positions& x,
                                              std::size_t q) noexcept {
    PointState s;
    s.F = x.template topRows<dimension>().lazyProduct(ref.gradient[q].transpose());
    s.E = 0.5 * (s.F.transpose() * s.F - Tensor::Identity());
    s.S = m.lambda() * s.E.trace() * Tensor::Identity() + 2 * m.mu() * s.E;
    return s;
  }

  static void evaluate(const Reference& ref, const Material& m, const Positions& x, bool tangent,
                       Response<nodes>& out) noexcept {
    out.clear(tangent);
    const double lambda = m.lambda(), mu = m.mu();
    for (std::size_t q = 0; q < points; ++q) {
      const PointState s = point_state(ref, m, x, q);
      const auto& B = ref.gradient[q];
      const double w = ref.measure[q];
      const Eigen::Matrix<double, dimension, nodes> SB = w * s.S * B;
      out.force.template topRows<dimension>().noalias() += s.F * SB;
      out.energy += 0.5 * w * s.S.cwiseProduct(s.E).sum();
      if (!tangent) continue;
      const Eigen::Matrix<double, dimension, nodes> FB = s.F * B;
      const Tensor FF = mu * w * s.F * s.F.transpose();
      for (int b = 0; b < nodes; ++b) {
        const Vector lambda_b = lambda * w * FB.col(b), mu_b = mu * w * FB.col(b);
        for (int a = 0; a < nodes; ++a) {
          Tensor K = FB.col(a) * lambda_b.transpose() + mu_b * FB.col(a).transpose();
          K += B.col(a).dot(B.col(b)) * FF;
          K.diagonal().array() += B.col(a).dot(SB.col(b));
          out.tangent.template block<dimension, dimension>(3 * a, 3 * b) += K;
        }
      }
    }
  }

  [[nodiscard]] static NodalMass lumped_mass(const Reference& ref, const Material& m) noexcept {
    return m.density * lumped_measure<Kind>(ref.measure);
  }

  /// In plane strain: of the stresses in the plane.
  [[nodiscard]] static PrincipalStress principal_stress(const PointState& s) noexcept {
    const Eigen::SelfAdjointEigenSolver<Tensor> eigen(s.S);
    PrincipalStress p{eigen.eigenvalues()(dimension - 1), eigen.eigenvalues()(0)};
    p.largest_direction.head<dimension>() = (s.F * eigen.eigenvectors().col(dimension - 1)).normalized();
    p.smallest_direction.head<dimension>() = (s.F * eigen.eigenvectors().col(0)).normalized();
    return p;
  }

 private:
  static constexpr double rounding = 1e-10;
};

} // namespace drogue::structure
