// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

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
  /// Half width delta of the strain interval in which a cable goes slack; 0: at once.
  double slack_strain = 0;
};

/// Straight two-node line, natural length L, current vector d = x_2 - x_1, length l = |d|, s = E eps + s_0:
///   green        f_2 = A s d / L,   tension N = A s l / L
///   engineering  f_2 = A s d / l,   tension N = A s
/// Weak form: int_0^L A s d(eps) dX = external work, exact with one point because eps is constant.
/// Stored energy A L w(eps) with dw/deps = s.
///
/// A cable with s <= 0 is slack: no force. Its tangent is not zero but `slack_stiffness` times EA/L in every
/// direction, so that a node that hangs on slack cables alone leaves the tangent regular; the force stays
/// exact. With slack_strain delta > 0 the switch is regularised: over |s| < E delta the stress is
/// (s + E delta)^2 / (4 E delta), so that stress and tangent are continuous.
struct Line {
  static constexpr mesh::ElementKind kind = mesh::ElementKind::line2;
  static constexpr int nodes = 2;
  static constexpr const char* irregular = "has length zero; move its nodes apart or give natural_length";
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

  [[nodiscard]] static bool regular(const Positions&, const Reference& ref) {
    return ref.natural_length > 0 && std::isfinite(ref.natural_length);
  }

  /// Tension N [force]; 0 when slack, negative in a truss under compression.
  [[nodiscard]] static double tension(const Reference& ref, const Material& m, const Positions& x) noexcept {
    const double l = (x.col(1) - x.col(0)).norm(), L = ref.natural_length;
    const double s = stress(m, l, L).s;
    return m.strain == StrainMeasure::green ? m.area * s * l / L : m.area * s;
  }

  /// dW/dL of the stored energy W at fixed ends [force]: what a change of the natural length costs.
  [[nodiscard]] static double energy_by_length(const Reference& ref, const Material& m,
                                               const Positions& x) noexcept {
    const double l = (x.col(1) - x.col(0)).norm(), L = ref.natural_length;
    const Stress stress_at = stress(m, l, L);
    const double L_deps_dL = m.strain == StrainMeasure::green ? -l * l / (L * L) : -l / L;
    return m.area * (stress_at.energy + stress_at.s * L_deps_dL);
  }

  static void evaluate(const Reference& ref, const Material& m, const Positions& x, bool tangent,
                       Response<2>& out) noexcept {
    out.clear(tangent);
    const Eigen::Vector3d d = x.col(1) - x.col(0);
    const double l = d.norm(), L = ref.natural_length, EA = m.youngs_modulus * m.area;
    const Stress stress_at = stress(m, l, L);
    Eigen::Matrix3d K;
    if (stress_at.slack) {
      K = (slack_stiffness * EA / L) * Eigen::Matrix3d::Identity();
    } else {
      // N_l = tension / l; a truss of length zero has no direction: a tiny length keeps the numbers finite.
      const bool green = m.strain == StrainMeasure::green;
      const double length = l > 0 ? l : tiny_length * L, E_A = stress_at.tangent * m.area;
      const double N_l = green ? m.area * stress_at.s / L : m.area * stress_at.s / length;
      const double axial = green ? E_A / (L * L * L) : (E_A / L - N_l) / (length * length);
      out.force.col(0) = -N_l * d;
      out.force.col(1) = N_l * d;
      out.energy = m.area * L * stress_at.energy;
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

  struct Stress {
    double s = 0;       ///< [stress]
    double tangent = 0; ///< ds/deps [stress]
    double energy = 0;  ///< w [energy per volume]
    bool slack = false; ///< all of them are zero
  };
  [[nodiscard]] static Stress stress(const Material& m, double l, double L) noexcept {
    const double strain = m.strain == StrainMeasure::green ? 0.5 * ((l * l) / (L * L) - 1) : (l - L) / L;
    const double E = m.youngs_modulus, s = E * strain + m.prestress;
    if (!m.tension_only) return {s, E, 0.5 * s * s / E, false};
    const double delta = E * m.slack_strain;
    if (s <= -delta) return {.slack = true};
    if (s >= delta) return {s, E, (0.5 * s * s + delta * delta / 6) / E, false};
    const double above = s + delta;
    return {above * above / (4 * delta), E * above / (2 * delta), above * above * above / (12 * delta * E),
            false};
  }
};

} // namespace drogue::structure
