// SPDX-License-Identifier: GPL-3.0-or-later
//
// Every kernel: tangent against finite differences at a non-trivial state, force against the energy's
// derivative, rigid motion, and exact stresses.
#include <tuple>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "structure_solver/elements/follower_pressure.hpp"
#include "structure_solver/elements/registry.hpp"
#include "tests/structure_solver/test_structures.hpp"

namespace drogue::structure {
namespace {

using mesh::ElementKind;
using test::Numbers;

/// Reference positions of one distorted element.
template <class Kernel>
typename Kernel::Positions reference_positions() {
  typename Kernel::Positions X;
  if constexpr (Kernel::nodes == 2) {
    X << 0.1, 1.2, 0.2, 0.9, -0.3, 0.4;
  } else {
    Numbers numbers;
    constexpr double xi9[] = {-1, 1, 1, -1, 0, 1, 0, -1, 0}, eta9[] = {-1, -1, 1, 1, -1, 0, 1, 0, 0};
    constexpr double xi3[] = {0, 1, 0}, eta3[] = {0, 0, 1};
    for (int a = 0; a < Kernel::nodes; ++a) {
      const double s = Kernel::nodes == 9 ? xi9[a] : xi3[a], t = Kernel::nodes == 9 ? eta9[a] : eta3[a];
      X.col(a) << s + 0.2 * t + 0.05 * numbers(), t - 0.1 * s + 0.05 * numbers(),
          0.3 * s * t + 0.05 * numbers();
    }
  }
  return X;
}

template <class Positions>
Positions moved(const Positions& X, double amount) {
  Numbers numbers;
  Positions x = X;
  for (int i = 0; i < x.size(); ++i) x(i) += amount * numbers();
  return x;
}

/// Largest difference between the tangent and central differences, relative to its largest entry.
template <int N, class Evaluate>
double tangent_error(const typename Response<N>::Positions& x, const Evaluate& evaluate) {
  Response<N> exact, plus, minus;
  evaluate(x, exact);
  const double h = 1e-6;
  double error = 0;
  for (int j = 0; j < 3 * N; ++j) {
    auto xp = x, xm = x;
    xp(j) += h;
    xm(j) -= h;
    evaluate(xp, plus);
    evaluate(xm, minus);
    for (int i = 0; i < 3 * N; ++i)
      error = std::max(error, std::abs((plus.force(i) - minus.force(i)) / (2 * h) - exact.tangent(i, j)));
  }
  return error / exact.tangent.cwiseAbs().maxCoeff();
}

template <class Kernel>
struct ElementCase {
  typename Kernel::Positions X = reference_positions<Kernel>();
  typename Kernel::Reference reference = Kernel::reference(X);
  typename Kernel::Material material;

  void evaluate(const typename Kernel::Positions& x, Response<Kernel::nodes>& out) const {
    Kernel::evaluate(reference, material, x, true, out);
  }
  void check_derivatives(const typename Kernel::Positions& x) const {
    EXPECT_LT(tangent_error<Kernel::nodes>(x, [this](const auto& y, auto& out) { evaluate(y, out); }), 1e-8);
    Response<Kernel::nodes> at, plus, minus;
    evaluate(x, at);
    const double h = 1e-6, scale = at.force.cwiseAbs().maxCoeff();
    for (int j = 0; j < 3 * Kernel::nodes; ++j) {
      auto xp = x, xm = x;
      xp(j) += h;
      xm(j) -= h;
      evaluate(xp, plus);
      evaluate(xm, minus);
      EXPECT_NEAR(at.force(j), (plus.energy - minus.energy) / (2 * h), 1e-7 * scale);
    }
  }
  void check_rigid_motion() const {
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    typename Kernel::Positions x = (R * X).colwise() + Eigen::Vector3d(30, -20, 10);
    Response<Kernel::nodes> out;
    evaluate(x, out);
    // A force of this size comes from strains of rounding size, at coordinates of size 30.
    EXPECT_LT(out.force.cwiseAbs().maxCoeff(), 1e-13 * out.tangent.cwiseAbs().maxCoeff());
  }
};

template <class Kernel>
ElementCase<Kernel> membrane_case(double prestress) {
  ElementCase<Kernel> c;
  c.material = {0.01, 6.0, 2e5, 0.3, prestress};
  return c;
}

ElementCase<Line> line_case(StrainMeasure strain, bool tension_only) {
  ElementCase<Line> c;
  c.material = {1e-3, 6.0, 4e6, 300.0, strain, tension_only};
  return c;
}

TEST(Membrane, TangentAndForceAreDerivatives) {
  const auto t3 = membrane_case<Membrane<ElementKind::tri3>>(400);
  t3.check_derivatives(moved(t3.X, 0.15));
  const auto q9 = membrane_case<Membrane<ElementKind::quad9>>(400);
  q9.check_derivatives(moved(q9.X, 0.15));
}

/// One element stretched and narrowed in its plane's first two directions, moved a little besides.
template <class Kernel>
typename Kernel::Positions deformed(const ElementCase<Kernel>& c, double stretch1, double stretch2) {
  Eigen::Matrix3d U = Eigen::Matrix3d::Identity();
  U(0, 0) = stretch1, U(1, 1) = stretch2;
  return moved(typename Kernel::Positions(U * c.X), 0.01);
}

template <class Kernel>
ElementCase<Kernel> tension_field_case(double prestress) {
  auto c = membrane_case<Kernel>(prestress);
  c.material.wrinkling = Wrinkling::tension_field;
  c.material.slack_stiffness = 0;
  return c;
}

template <class Kernel>
void check_tension_field() {
  for (const double prestress : {0.0, 400.0}) {
    const auto c = tension_field_case<Kernel>(prestress);
    for (const auto& [s1, s2, state] :
         {std::tuple(1.2, 1.15, WrinkleState::taut), std::tuple(1.2, 0.7, WrinkleState::wrinkled),
          std::tuple(0.6, 1.2, WrinkleState::wrinkled)}) {
      const auto x = deformed(c, s1, s2);
      for (std::size_t q = 0; q < Kernel::points; ++q)
        ASSERT_EQ(Kernel::point_state(c.reference, c.material, x, q).wrinkle_state, state);
      c.check_derivatives(x);
    }
  }
}

TEST(TensionField, TangentAndForceAreDerivatives) {
  check_tension_field<Membrane<ElementKind::tri3>>();
  check_tension_field<Membrane<ElementKind::quad9>>();
}

TEST(TensionField, SlackClothPullsNothingAndKeepsARegularTangent) {
  using Kernel = Membrane<ElementKind::quad9>;
  auto c = tension_field_case<Kernel>(400);
  c.material.slack_stiffness = 1e-6;
  Response<9> out;
  c.evaluate(deformed(c, 0.5, 0.6), out);
  EXPECT_EQ(out.force.cwiseAbs().maxCoeff(), 0);
  const Eigen::Vector<double, 27> stiffness =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 27, 27>>(out.tangent).eigenvalues();
  const double Eh = c.material.youngs_modulus * c.material.thickness;
  EXPECT_LT(std::abs(stiffness(2)), 1e-15 * Eh); // rigid translations
  EXPECT_GT(stiffness(3), 1e-8 * Eh);
  EXPECT_LT(stiffness(26), 1e-4 * Eh);
}

/// A compressed plate has lost stiffness across its plane; the tangent of a tension field is never
/// indefinite.
TEST(TensionField, TangentIsNeverIndefinite) {
  using Kernel = Membrane<ElementKind::quad9>;
  const auto field = tension_field_case<Kernel>(0), plate = membrane_case<Kernel>(0);
  const auto smallest = [](const auto& c, double stretch) {
    Response<9> out;
    c.evaluate(moved(Kernel::Positions(stretch * c.X), 0.2), out);
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 27, 27>>(out.tangent).eigenvalues()(0);
  };
  const double Eh = field.material.youngs_modulus * field.material.thickness;
  for (const double stretch : {1.3, 1.0, 0.7}) EXPECT_GE(smallest(field, stretch), -1e-12 * Eh);
  EXPECT_LT(smallest(plate, 0.7), -1e-3 * Eh);
}

TEST(TensionField, AnswersTheSameInEveryFrame) {
  using Kernel = Membrane<ElementKind::tri3>;
  const auto c = tension_field_case<Kernel>(400);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  for (const auto& x : {deformed(c, 1.2, 1.15), deformed(c, 1.2, 0.7)}) {
    Response<3> here, there, renumbered;
    c.evaluate(x, here);
    c.evaluate(R * x, there);
    EXPECT_LT((there.force - R * here.force).norm(), 1e-12 * here.force.norm());
    EXPECT_NEAR(there.energy, here.energy, 1e-12 * here.energy);
    // Another first node turns the frame of the reference plane.
    const auto turn = [](const auto& X) {
      Kernel::Positions Y;
      Y << X.col(1), X.col(2), X.col(0);
      return Y;
    };
    Kernel::evaluate(Kernel::reference(turn(c.X)), c.material, turn(x), true, renumbered);
    EXPECT_LT((renumbered.force - turn(here.force)).norm(), 1e-12 * here.force.norm());
    EXPECT_LT((renumbered.tangent.topLeftCorner<6, 6>() - here.tangent.bottomRightCorner<6, 6>()).norm(),
              1e-12 * here.tangent.norm());
  }
}

TEST(Membrane, RigidMotionGivesNoForce) {
  membrane_case<Membrane<ElementKind::tri3>>(0).check_rigid_motion();
  membrane_case<Membrane<ElementKind::quad9>>(0).check_rigid_motion();
}

TEST(Membrane, AWrongTangentIsSeen) {
  const auto t3 = membrane_case<Membrane<ElementKind::tri3>>(0);
  const double error = tangent_error<3>(moved(t3.X, 0.15), [&](const auto& x, auto& out) {
    t3.evaluate(x, out);
    out.tangent *= 1 + 1e-6;
  });
  EXPECT_GT(error, 5e-7);
}

TEST(Membrane, MassIsThatOfTheCloth) {
  const auto q9 = membrane_case<Membrane<ElementKind::quad9>>(0);
  const auto mass = Membrane<ElementKind::quad9>::lumped_mass(q9.reference, q9.material);
  double area = 0;
  for (const double a : q9.reference.measure) area += a;
  EXPECT_NEAR(mass.sum(), 6.0 * 0.01 * area, 1e-14);
  EXPECT_GT(mass.minCoeff(), 0);
}

TEST(Line, TangentAndForceAreDerivatives) {
  for (const auto strain : {StrainMeasure::green, StrainMeasure::engineering})
    for (const double scale : {0.8, 1.3}) {
      const auto truss = line_case(strain, false);
      truss.check_derivatives(moved(Line::Positions(scale * truss.X), 0.05));
    }
  const auto cable = line_case(StrainMeasure::green, true);
  cable.check_derivatives(1.1 * cable.X);
}

TEST(Line, RigidMotionGivesNoForce) {
  for (const auto strain : {StrainMeasure::green, StrainMeasure::engineering}) {
    auto truss = line_case(strain, false);
    truss.material.prestress = 0;
    truss.check_rigid_motion();
  }
}

TEST(Line, ForceIsTheTensionOfTheChosenStrain) {
  Line::Positions x;
  x << 0, 3, 0, 0, 0, 0;
  const Line::Reference natural{2.5}; // a stretch of 1.2
  LineMaterial material{1e-3, 0, 4e6, 0, StrainMeasure::engineering, true};
  EXPECT_NEAR(Line::tension(natural, material, x), 4000 * 0.2, 1e-10);
  material.strain = StrainMeasure::green;
  EXPECT_NEAR(Line::tension(natural, material, x), 4000 * 0.22 * 1.2, 1e-10);
  Response<2> out;
  Line::evaluate(natural, material, x, false, out);
  EXPECT_NEAR(out.force(0, 1), Line::tension(natural, material, x), 1e-10);
}

TEST(Line, RegularisedSlackSwitchIsContinuousAndExactOutside) {
  for (const StrainMeasure strain : {StrainMeasure::green, StrainMeasure::engineering}) {
    ElementCase<Line> sharp = line_case(strain, true), smooth = sharp;
    smooth.material.slack_strain = 0.05;
    const double taut_at = 1 - sharp.material.prestress / sharp.material.youngs_modulus;
    for (const double scale : {taut_at - 0.03, taut_at, taut_at + 0.03})
      smooth.check_derivatives(Line::Positions(scale * smooth.X));
    const auto tension = [](const ElementCase<Line>& c, double scale) {
      return Line::tension(c.reference, c.material, scale * c.X);
    };
    EXPECT_GT(tension(smooth, taut_at), 0);
    EXPECT_EQ(tension(smooth, taut_at - 0.1), 0);
    EXPECT_EQ(tension(smooth, taut_at + 0.1), tension(sharp, taut_at + 0.1));
  }
}

TEST(Line, EnergyByLengthIsTheDerivative) {
  for (const StrainMeasure strain : {StrainMeasure::green, StrainMeasure::engineering})
    for (const double scale : {0.98, 1.01, 1.2}) {
      ElementCase<Line> c = line_case(strain, true);
      c.material.slack_strain = 0.05;
      const auto energy = [&](double length) {
        Response<2> out;
        Line::evaluate({length}, c.material, scale * c.X, false, out);
        return out.energy;
      };
      const double L = c.reference.natural_length, h = 1e-5 * L;
      const double expected = (energy(L + h) - energy(L - h)) / (2 * h);
      EXPECT_NEAR(Line::energy_by_length(c.reference, c.material, scale * c.X), expected,
                  1e-7 * std::abs(expected) + 1e-9);
    }
}

TEST(Line, SlackCablePullsNothingAndKeepsARegularTangent) {
  const auto cable = line_case(StrainMeasure::green, true);
  Response<2> out;
  Line::evaluate(cable.reference, cable.material, 0.9 * cable.X, true, out);
  EXPECT_EQ(out.force.cwiseAbs().maxCoeff(), 0);
  EXPECT_EQ(out.energy, 0);
  EXPECT_EQ(Line::tension(cable.reference, cable.material, 0.9 * cable.X), 0);
  const Eigen::Matrix3d K = out.tangent.topLeftCorner<3, 3>();
  const double EA_L = cable.material.youngs_modulus * cable.material.area / cable.reference.natural_length;
  EXPECT_GT(K.determinant(), 0);
  EXPECT_LT(K.norm(), 1e-7 * EA_L);
}

template <ElementKind Kind>
void check_follower_pressure() {
  using Kernel = FollowerPressure<Kind>;
  const auto X = reference_positions<Membrane<Kind>>();
  const auto x = moved(X, 0.15);
  typename Kernel::NodalPressure p;
  Numbers numbers;
  for (int a = 0; a < Kernel::nodes; ++a) p(a) = 2 + numbers();
  EXPECT_LT(
      tangent_error<Kernel::nodes>(
          x, [&](const auto& y, auto& out) { Kernel::evaluate(element_rule<Kind>(), p, y, true, out); }),
      1e-9);
}

TEST(FollowerPressure, LoadStiffnessIsTheDerivative) {
  check_follower_pressure<ElementKind::tri3>();
  check_follower_pressure<ElementKind::quad9>();
}

TEST(FollowerPressure, PushesAlongTheRightHandedNormal) {
  Response<3>::Positions x;
  x << 0, 2, 0, 0, 0, 3, 0, 0, 0; // normal +z, area 3
  Response<3> out;
  const auto& rule = element_rule<ElementKind::tri3>();
  FollowerPressure<ElementKind::tri3>::evaluate(rule, Eigen::Vector3d(5, 5, 5), x, false, out);
  const Eigen::Vector3d external = -out.force.rowwise().sum();
  EXPECT_NEAR(external(2), 15, 1e-14);
  EXPECT_NEAR(std::hypot(external(0), external(1)), 0, 1e-14);
}

} // namespace
} // namespace drogue::structure
