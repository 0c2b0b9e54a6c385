// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Dense>

#include "common/mesh/mesh.hpp"
#include "structure_solver/elements/element.hpp"

namespace drogue::structure {

enum class StrainMeasure {
  green,       ///< 1/2 (l^2 - L^2) / L^2, work-conjugate to the second Piola-Kirchhoff stress
  engineering, ///< (l - L) / L, work-conjugate to the nominal stress
};

/// Two-node cable (tension only) or truss.
struct LineMaterial {
  double area = 0;           ///< A [area]
  double density = 0;        ///< rho_0 [mass per volume]
  double youngs_modulus = 0; ///< E [stress]
  double prestress = 0;      ///< stress in the natural configuration [stress]
  StrainMeasure strain = StrainMeasure::green;
  bool tension_only = false; ///< goes slack under compression
};

/// Straight two-node line, natural length L, current vector d = x_2 - x_1, length l = |d|, s = E eps + s_0:
///   green        f_2 = A s d / L,   tension N = A s l / L
///   engineering  f_2 = A s d / l,   tension N = A s
/// Weak form: int_0^L A s d(eps) dX = external work, exact with one point because eps is constant.
///
/// A cable with s <= 0 is slack: no force. Its tangent is not zero but `slack_stiffness` times EA/L in every
/// direction, so that a node that hangs on slack cables alone leaves the tangent regular; the force stays
/// exact.
struct Line {
  static constexpr mesh::ElementKind kind = mesh::ElementKind::line2;
  static constexpr int nodes = 2;
  static constexpr double slack_stiffness = 1e-8;
  using Positions = Response<2>::Positions;
  using NodalMass = Eigen::Vector2d;
  using Material = LineMaterial;
  struct Reference {
    double natural_length = 0; ///< L [length]
  };

  [[nodiscard]] static Reference reference(const Positions& X) noexcept {
    return {(X.col(1) - X.col(0)).norm()};
  }

  /// Tension N [force]; 0 when slack, negative in a truss under compression.
  [[nodiscard]] static double tension(const Reference& ref, const Material& m, const Positions& x) noexcept {
    const double l = (x.col(1) - x.col(0)).norm(), L = ref.natural_length;
    const double s = stress(m, l, L);
    if (m.tension_only && s <= 0) return 0;
    return m.strain == StrainMeasure::green ? m.area * s * l / L : m.area * s;
  }

  static void evaluate(const Reference& ref, const Material& m, const Positions& x, bool tangent,
                       Response<2>& out) noexcept {
    out.clear(tangent);
    const Eigen::Vector3d d = x.col(1) - x.col(0);
    const double l = d.norm(), L = ref.natural_length, EA = m.youngs_modulus * m.area;
    const double s = stress(m, l, L);
    Eigen::Matrix3d K;
    if (m.tension_only && s <= 0) {
      K = (slack_stiffness * EA / L) * Eigen::Matrix3d::Identity();
    } else {
      // N_l = tension / l; a truss of length zero has no direction: a tiny length keeps the numbers finite.
      const bool green = m.strain == StrainMeasure::green;
      const double length = l > 0 ? l : tiny_length * L;
      const double N_l = green ? m.area * s / L : m.area * s / length;
      const double axial = green ? EA / (L * L * L) : (EA / L - N_l) / (length * length);
      out.force.col(0) = -N_l * d;
      out.force.col(1) = N_l * d;
      out.energy = 0.5 * m.area * L * s * s / m.youngs_modulus;
      K = axial * d * d.transpose() + N_l * Eigen::Matrix3d::Identity();
    }
    if (!tangent) return;
    out.tangent << K, -K, -K, K;
  }

  [[nodiscard]] static NodalMass lumped_mass(const Reference& ref, const Material& m) noexcept {
    return NodalMass::Constant(0.5 * m.density * m.area * ref.natural_length);
  }

 private:
  static constexpr double tiny_length = 1e-12;

  [[nodiscard]] static double stress(const Material& m, double l, double L) noexcept {
    const double strain = m.strain == StrainMeasure::green ? 0.5 * ((l * l) / (L * L) - 1) : (l - L) / L;
    return m.youngs_modulus * strain + m.prestress;
  }
};

} // namespace drogue::structure
