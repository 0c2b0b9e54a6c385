// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace drogue::structure {

enum class Wrinkling {
  none,          ///< carries compression like a plate that cannot buckle
  tension_field, ///< carries none: wrinkles form without resistance
};

/// State of the cloth at a point by the mixed criterion [kang1997]; the numbers are those of the output
/// field.
enum class WrinkleState {
  slack = 0,    ///< both principal strains negative: no stress
  wrinkled = 1, ///< stretched one way, too narrow the other way: uniaxial tension
  taut = 2,     ///< both principal stresses positive
};

/// A membrane's constants.
struct MembraneMaterial {
  double thickness = 0;      ///< h [length], constant
  double density = 0;        ///< rho_0 [mass per volume]
  double youngs_modulus = 0; ///< E [stress]
  double poisson_ratio = 0;  ///< nu
  double prestress = 0;      ///< S_0 [stress], isotropic, in the reference configuration
  Wrinkling wrinkling = Wrinkling::none;
  /// Tension field: the tangent of a point that is not taut is that of a membrane with the additional tension
  /// slack_stiffness E in every direction. Stress and energy are not touched.
  double slack_stiffness = 1e-6;
};

/// Answer of the law to a strain.
struct PlaneStress {
  Eigen::Vector3d S; ///< second Piola-Kirchhoff stress S_11, S_22, S_12 [stress]
  double energy = 0; ///< per reference volume, zero in the reference configuration [stress]
};

/// Plane stress, St. Venant-Kirchhoff with isotropic prestress, with or without a tension field.
///
/// The prestress is a shift of the strain, e = E + eps_0 I with eps_0 = (1 - nu) S_0 / E, so that e = 0 is
/// free of stress: S = c ((1 - nu) e + nu tr(e) I), c = E / (1 - nu^2).
///
/// Tension field: the cloth may shorten freely by wrinkling. It takes the wrinkling strain P >= 0 that makes
/// its energy least, W_r(e) = min_P W(e + P) [pipkin1986], hence S = C : (e + P) >= 0 and S : P = 0. Stress
/// and strain of an isotropic law share their principal directions n_1, n_2, and the minimum is known in
/// closed form, in principal strains e_1 >= e_2:
///   taut      S_2 = c (e_2 + nu e_1) > 0          S_1 = c (e_1 + nu e_2)
///   wrinkled  otherwise, while e_1 > 0            S_1 = E e_1,  S_2 = 0
///   slack     otherwise                           S_1 = S_2 = 0
/// which is the mixed stress-strain criterion. W_r is convex with a continuous derivative S, and the tangent
/// of the membrane is never indefinite.
class PlaneStressLaw {
 public:
  explicit PlaneStressLaw(const MembraneMaterial& m) noexcept
      : E_(m.youngs_modulus),
        nu_(m.poisson_ratio),
        c_(E_ / (1 - nu_ * nu_)),
        G_(0.5 * E_ / (1 + nu_)),
        shift_((1 - nu_) * m.prestress / E_),
        stored_(shift_ * m.prestress),
        tension_field_(m.wrinkling == Wrinkling::tension_field),
        slack_tension_(m.slack_stiffness * E_) {}

  /// @param strain E_11, E_22, 2 E_12
  [[nodiscard]] PlaneStress stress(const Eigen::Vector3d& strain) const noexcept {
    return tension_field_ ? relaxed(principal(strain)) : linear(strain);
  }

  /// The stress, and its derivative dS/dE [stress], symmetric.
  /// @param geometric_tension what the tangent takes in addition to S in its geometric part [stress]
  [[nodiscard]] PlaneStress stress(const Eigen::Vector3d& strain, Eigen::Matrix3d& modulus,
                                   double& geometric_tension) const noexcept {
    geometric_tension = 0;
    modulus << c_, c_ * nu_, 0, c_ * nu_, c_, 0, 0, 0, G_;
    if (!tension_field_) return linear(strain);
    const Principal p = principal(strain);
    const WrinkleState now = state(p);
    if (now == WrinkleState::taut) return relaxed(p);
    geometric_tension = slack_tension_;
    modulus.setZero();
    if (now == WrinkleState::slack) return relaxed(p);
    // S = E e_1 n_1 n_1. In the frame of n_1, n_2: de_1 = m . dE, and n_1 n_1 turns by
    // d(n_1 n_1) = (n_1 n_2 + n_2 n_1) r . dE / (2 (e_1 - e_2)). Since e_2 <= -nu e_1 the divisor is not
    // zero.
    const Eigen::Vector3d m(p.cos2, p.sin2, p.sin_cos);
    const Eigen::Vector3d r(-2 * p.sin_cos, 2 * p.sin_cos, p.cos2 - p.sin2);
    const double rotation = 0.5 * E_ * p.e1 / (p.e1 - p.e2);
    modulus.noalias() = E_ * m * m.transpose() + rotation * r * r.transpose();
    return relaxed(p);
  }

  /// What the mixed criterion says about a strain, for either law.
  [[nodiscard]] WrinkleState state(const Eigen::Vector3d& strain) const noexcept {
    return state(principal(strain));
  }

 private:
  /// Principal strains e_1 >= e_2 of the shifted strain, and squares and product of cosine and sine of the
  /// angle from the first axis to n_1.
  struct Principal {
    double e1, e2, cos2, sin2, sin_cos;
  };

  [[nodiscard]] Principal principal(const Eigen::Vector3d& strain) const noexcept {
    const double mean = 0.5 * (strain(0) + strain(1)) + shift_;
    const double half_difference = 0.5 * (strain(0) - strain(1)), half_shear = 0.5 * strain(2);
    const double radius = std::sqrt(half_difference * half_difference + half_shear * half_shear);
    const bool isotropic = !(radius > 0); // any direction will do
    const double inverse = isotropic ? 0 : 1 / radius;
    const double cos_double = isotropic ? 1 : half_difference * inverse, sin_double = half_shear * inverse;
    return {mean + radius, mean - radius, 0.5 * (1 + cos_double), 0.5 * (1 - cos_double), 0.5 * sin_double};
  }

  [[nodiscard]] WrinkleState state(const Principal& p) const noexcept {
    if (p.e2 + nu_ * p.e1 > 0) return WrinkleState::taut;
    return p.e1 > 0 ? WrinkleState::wrinkled : WrinkleState::slack;
  }

  [[nodiscard]] PlaneStress linear(const Eigen::Vector3d& strain) const noexcept {
    const double e11 = strain(0) + shift_, e22 = strain(1) + shift_;
    PlaneStress out{{c_ * (e11 + nu_ * e22), c_ * (e22 + nu_ * e11), G_ * strain(2)}, 0};
    out.energy = 0.5 * (out.S(0) * e11 + out.S(1) * e22 + out.S(2) * strain(2)) - stored_;
    return out;
  }

  [[nodiscard]] PlaneStress relaxed(const Principal& p) const noexcept {
    const bool taut = p.e2 + nu_ * p.e1 > 0;
    const double S1 = taut ? c_ * (p.e1 + nu_ * p.e2) : std::max(0.0, E_ * p.e1);
    const double S2 = taut ? c_ * (p.e2 + nu_ * p.e1) : 0;
    return {{S1 * p.cos2 + S2 * p.sin2, S1 * p.sin2 + S2 * p.cos2, (S1 - S2) * p.sin_cos},
            0.5 * (S1 * p.e1 + S2 * p.e2) - stored_};
  }

  double E_, nu_, c_, G_;
  double shift_;  // eps_0
  double stored_; // energy of the prestress in the reference configuration
  bool tension_field_;
  double slack_tension_;
};

} // namespace drogue::structure
