// SPDX-License-Identifier: GPL-3.0-or-later
//
// The membrane's law at a point: derivatives in the three states and close to their borders, exact states,
// and the tension field as the least energy over all wrinkling strains.
#include <numbers>

#include <gtest/gtest.h>

#include "structure_solver/elements/plane_stress.hpp"
#include "tests/structure_solver/test_structures.hpp"

namespace drogue::structure {
namespace {

constexpr double E = 800, nu = 0.3;

MembraneMaterial cloth(Wrinkling wrinkling, double prestress = 0) {
  return {.thickness = 1,
          .density = 1,
          .youngs_modulus = E,
          .poisson_ratio = nu,
          .prestress = prestress,
          .wrinkling = wrinkling};
}

/// Strain with principal values e1, e2 in a frame at `angle`, less the shift of the prestress.
Eigen::Vector3d strain(double e1, double e2, double angle, double prestress = 0) {
  const double c = std::cos(angle), s = std::sin(angle), shift = (1 - nu) * prestress / E;
  return {e1 * c * c + e2 * s * s - shift, e1 * s * s + e2 * c * c - shift, 2 * (e1 - e2) * c * s};
}

struct Point {
  double e1, e2;
  WrinkleState state;
};
/// Every state, and points at a tenth of a per mille of the strain from the borders.
const Point points[] = {
    {0.02, 0.01, WrinkleState::taut},
    {0.02, -0.005, WrinkleState::taut},
    {0.02, -0.005999, WrinkleState::taut},
    {0.02, -0.006001, WrinkleState::wrinkled},
    {0.02, -0.03, WrinkleState::wrinkled},
    {0.000002, -0.03, WrinkleState::wrinkled},
    {-0.000002, -0.03, WrinkleState::slack},
    {-0.01, -0.03, WrinkleState::slack},
    {0.0000001, -0.0000009, WrinkleState::wrinkled},
};

TEST(PlaneStress, StressIsTheDerivativeOfTheEnergyAndTheTangentThatOfTheStress) {
  for (const double prestress : {0.0, 3.0})
    for (const Wrinkling wrinkling : {Wrinkling::none, Wrinkling::tension_field})
      for (const double angle : {0.0, 0.4, 2.0, std::numbers::pi / 2})
        for (const Point& p : points) {
          const PlaneStressLaw law(cloth(wrinkling, prestress));
          const Eigen::Vector3d at = strain(p.e1, p.e2, angle, prestress);
          ASSERT_EQ(law.state(at), p.state);
          Eigen::Matrix3d C;
          double tension = 0;
          const PlaneStress answer = law.stress(at, C, tension);
          EXPECT_EQ((answer.S - law.stress(at).S).norm(), 0);
          EXPECT_LT((C - C.transpose()).norm(), 1e-15 * E);
          const double h = 2e-9;
          for (int j = 0; j < 3; ++j) {
            const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(j);
            const PlaneStress plus = law.stress(at + step), minus = law.stress(at - step);
            EXPECT_LT(((plus.S - minus.S) / (2 * h) - C.col(j)).norm(), 1e-5 * E) << p.e1 << " " << p.e2;
            EXPECT_NEAR((plus.energy - minus.energy) / (2 * h), answer.S(j), 2e-6);
          }
        }
}

TEST(PlaneStress, StressIsContinuousAtTheBorders) {
  const PlaneStressLaw law(cloth(Wrinkling::tension_field));
  const double tiny = 1e-12;
  for (const auto& [e1, e2] : {std::pair(0.02, -nu * 0.02), std::pair(0.0, -0.03), std::pair(0.0, 0.0)}) {
    const Eigen::Vector3d before = law.stress(strain(e1 + tiny, e2 + tiny, 0.7)).S,
                          after = law.stress(strain(e1 - tiny, e2 - tiny, 0.7)).S;
    EXPECT_LT((before - after).norm(), 10 * E * tiny);
  }
}

TEST(PlaneStress, UniaxialTensionWithAnyFurtherContraction) {
  const PlaneStressLaw law(cloth(Wrinkling::tension_field));
  for (const double lateral : {-nu * 0.02, -0.01, -0.3}) {
    const PlaneStress s = law.stress({0.02, lateral, 0});
    EXPECT_NEAR(s.S(0), E * 0.02, 1e-13);
    EXPECT_NEAR(s.S(1), 0, 1e-13);
    EXPECT_EQ(s.S(2), 0);
    EXPECT_NEAR(s.energy, 0.5 * E * 0.02 * 0.02, 1e-13);
  }
}

/// A sheet sheared between rigid edges [wagner1931]: tension in the direction of the largest stretch. With
/// E_12 = gamma/2 and E_22 = gamma^2/2: e_1 = (E_22 + sqrt(E_22^2 + gamma^2)) / 2, S_12 = E e_1 sin cos.
TEST(PlaneStress, ShearGivesADiagonalTension) {
  const PlaneStressLaw law(cloth(Wrinkling::tension_field));
  const double gamma = 0.01;
  const PlaneStress s = law.stress({0, 0.5 * gamma * gamma, gamma});
  const double E22 = 0.5 * gamma * gamma, root = std::sqrt(E22 * E22 + gamma * gamma);
  EXPECT_NEAR(s.S(2), E * 0.5 * (E22 + root) * 0.5 * gamma / root, 1e-12);
  EXPECT_NEAR(s.S(0) * s.S(1), s.S(2) * s.S(2), 1e-12); // uniaxial
  EXPECT_NEAR(s.S(2) / (E * gamma / 4), 1, 0.01); // E gamma / 4, where the plate has E gamma / (2 (1 + nu))
}

TEST(PlaneStress, ATensionFieldIsLinearWhereTautAndEmptyWhereSlack) {
  for (const double prestress : {0.0, 3.0}) {
    const PlaneStressLaw field(cloth(Wrinkling::tension_field, prestress)),
        plate(cloth(Wrinkling::none, prestress));
    const Eigen::Vector3d taut = strain(0.02, -0.005, 0.3, prestress),
                          slack = strain(-1e-3, -0.2, 0.3, prestress);
    EXPECT_LT((field.stress(taut).S - plate.stress(taut).S).norm(), 1e-13);
    EXPECT_NEAR(field.stress(taut).energy, plate.stress(taut).energy, 1e-14);
    EXPECT_EQ(field.stress(slack).S.norm(), 0);
    EXPECT_NEAR(field.stress(slack).energy, -(1 - nu) * prestress * prestress / E, 1e-15);
    EXPECT_LT((field.stress(Eigen::Vector3d::Zero()).S - prestress * Eigen::Vector3d(1, 1, 0)).norm(), 1e-13);
    EXPECT_NEAR(field.stress(Eigen::Vector3d::Zero()).energy, 0, 1e-15);
  }
}

TEST(PlaneStress, TensionFieldEnergyIsTheLeastOverTheWrinklingStrains) {
  const PlaneStressLaw field(cloth(Wrinkling::tension_field)), plate(cloth(Wrinkling::none));
  for (const Point& p : points) {
    const Eigen::Vector3d at = strain(p.e1, p.e2, 0.4);
    const double energy = field.stress(at).energy, scale = 0.5 * E * (p.e1 * p.e1 + p.e2 * p.e2);
    double least = plate.stress(at).energy;
    // Wrinkling strains a in direction t and b across it, in steps of a hundredth of the strain.
    for (int i = 0; i <= 100; ++i)
      for (int j = 0; j <= 100; ++j)
        for (const double t : {0.4, 0.0, 0.9}) {
          const Eigen::Vector3d wrinkle = strain(-0.01 * i * p.e2, -0.01 * j * p.e2, t);
          if (p.e2 > 0) break;
          const double W = plate.stress(at + wrinkle).energy;
          EXPECT_GE(W, energy - 1e-12 * scale);
          least = std::min(least, W);
        }
    EXPECT_NEAR(least, energy, 1e-3 * scale);
  }
}

} // namespace
} // namespace drogue::structure
