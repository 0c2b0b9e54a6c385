// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "surfaces.hpp"

namespace drogue::projection::test {
namespace {

using Eigen::Vector3d;

std::vector<double> moved(const Surface& s, double amount) {
  std::vector<double> x = sample(s, wavy);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = s.points[i] + amount * x[i];
  return x;
}

std::vector<double> pressures(const Surface& s, const std::function<double(const Point&)>& p) {
  std::vector<double> values;
  for (std::size_t i = 0; i < s.points.size(); i += 3)
    values.push_back(p({s.points[i], s.points[i + 1], s.points[i + 2]}));
  return values;
}

struct Loaded {
  std::vector<double> forces;
  LoadSums given;
};
Loaded press(Interface& interface, const std::vector<double>& x, const std::vector<double>& p,
             const std::vector<double>& v = {}) {
  Loaded result;
  result.forces.resize(interface.structure.points.size());
  result.given = interface.load.from_pressure({x, v}, p, result.forces);
  return result;
}

TEST(LoadTransfer, SumOfForcesIsTheIntegralOnAnyPairAndShape) {
  const std::pair<Surface, Surface> pairs[] = {{octahedron_hemisphere(9), lat_long_hemisphere(8)},
                                               {quad9_hemisphere(2), lat_long_hemisphere(10)},
                                               {disc(ElementKind::quad9, 3), two_sided_disc(7)},
                                               {sphere(4), sphere(6)}};
  for (const auto& [structure, fluid] : pairs) {
    Interface interface = pair(structure, fluid, {.largest_gap = 0.1});
    const auto x = moved(fluid, 0.2);
    std::vector<double> p; // not the same on the two sides
    for (std::size_t i = 0; i < fluid.node_count(); ++i)
      p.push_back(2 + std::sin(0.01 * static_cast<double>(i)));
    const Loaded load = press(interface, x, p);
    const LoadSums received = sum_nodal(structure.points, load.forces);
    double magnitude = 0;
    for (const double f : load.forces) magnitude += std::abs(f);
    EXPECT_LT((received.force - load.given.force).norm(), 1e-12 * magnitude);
    EXPECT_GT(magnitude, 0.1);
    // Independent: areas of the triangles times the mean of their nodes' pressures.
    Vector3d direct = Vector3d::Zero();
    for (const auto& block : fluid.blocks) {
      for (std::int32_t e = 0; e < block.count(); ++e) {
        const auto n = block.element(e);
        const NodeMatrix X = gather(n, x);
        double mean = 0;
        for (const auto node : n) mean += p[static_cast<std::size_t>(node)] / 3;
        direct += 0.5 * mean * (X.col(1) - X.col(0)).cross(X.col(2) - X.col(0));
      }
    }
    EXPECT_LT((received.force - direct).norm(), 1e-12 * magnitude);
  }
}

TEST(LoadTransfer, SignPositivePressurePushesAlongTheNormalOutOfTheFluid) {
  const Surface structure = plate(ElementKind::quad9, 2),
                fluid = plate(ElementKind::tri3, 3); // normal +z: fluid below
  Interface interface = pair(structure, fluid);
  const Loaded load = press(interface, fluid.points, std::vector<double>(fluid.node_count(), 4.0));
  const Vector3d f = sum_nodal(structure.points, load.forces).force;
  EXPECT_NEAR(f.z(), 4, 1e-12);
  EXPECT_NEAR(f.head<2>().norm(), 0, 1e-12);
  // Two sides with the pressures p1 below and p2 above: the canopy feels p1 - p2 upwards.
  const Surface two = two_sided_disc(6), cloth = disc(ElementKind::tri3, 5);
  std::vector<double> p(two.node_count(), 3.0);
  for (const std::int32_t node : two.blocks[1].nodes) p[static_cast<std::size_t>(node)] = 1.0;
  for (std::size_t i = 0; i < two.node_count(); ++i) // single nodes on the rim carry the mean
    if (other_side(two)[i] == static_cast<std::int32_t>(i)) p[i] = 2.0;
  Interface canopy = pair(cloth, two);
  EXPECT_GT(sum_nodal(cloth.points, press(canopy, two.points, p).forces).force.z(), 0.5);
  const std::vector<double> same(two.node_count(), 3.0);
  EXPECT_LT(largest_difference(press(canopy, two.points, same).forces,
                               std::vector<double>(cloth.points.size(), 0.0)),
            1e-13);
}

TEST(LoadTransfer, UniformPressureOnAClosedSurfaceHasNoResultant) {
  const Surface structure = sphere(6);
  for (const Surface& fluid : {sphere(6), sphere(9)}) {
    Interface interface = pair(structure, fluid, {.largest_gap = 0.1});
    const Loaded load = press(interface, moved(fluid, 0.1), std::vector<double>(fluid.node_count(), 5.0));
    const LoadSums received = sum_nodal(structure.points, load.forces);
    EXPECT_LT(received.force.norm(), 1e-12);
    EXPECT_LT(load.given.moment.norm(), 1e-12);
    EXPECT_GT(Vector3d(load.forces[0], load.forces[1], load.forces[2]).norm(), 1e-2);
  }
}

TEST(LoadTransfer, MomentAndPowerAgreeWhereTheSurfacesCoincide) {
  const Surface structure = plate(ElementKind::quad9, 3), fluid = plate(ElementKind::tri3, 5);
  Interface interface = pair(structure, fluid);
  const auto p = pressures(fluid, [](const Point& q) { return 1 + q[0] * q[0]; });
  const auto velocity = [](const Point& q) { return Point{q[1], 0, 2 - q[0] + q[1]}; };
  const auto v_s = sample(structure, velocity), v_f = sample(fluid, velocity);
  const Loaded load = press(interface, fluid.points, p, v_f);
  const LoadSums received = sum_nodal(structure.points, load.forces, v_s);
  EXPECT_LT((received.moment - load.given.moment).norm(), 1e-12);
  EXPECT_NEAR(received.power, load.given.power, 1e-12);
  EXPECT_GT(load.given.moment.norm(), 0.1);
  EXPECT_GT(load.given.power, 0.1);
}

TEST(LoadTransfer, PressureAndTheSameTractionAgree) {
  const Surface structure = disc(ElementKind::tri3, 5), fluid = disc(ElementKind::tri3, 7);
  Interface interface = pair(structure, fluid);
  const auto p = pressures(fluid, [](const Point& q) { return 1 + q[0] - 2 * q[1]; });
  std::vector<double> t(fluid.points.size(), 0.0), forces(structure.points.size());
  for (std::size_t i = 0; i < p.size(); ++i) t[3 * i + 2] = p[i];
  const LoadSums sums = interface.load.from_traction({fluid.points, {}}, t, forces);
  const Loaded load = press(interface, fluid.points, p);
  EXPECT_LT(largest_difference(forces, load.forces), 1e-14);
  EXPECT_LT((sums.force - load.given.force).norm(), 1e-13);
}

/// Tractions in the structure's space come back to rounding, on surfaces that coincide, one-sided or
/// two-sided.
TEST(RecoverTraction, ConstantAndLinearTractionsAreExact) {
  const Point each{0.5, -2, 3};
  for (const Surface& structure :
       {plate(ElementKind::tri3, 9), plate(ElementKind::quad9, 4), plate(ElementKind::tri6, 3)}) {
    const Surface fluid = plate(ElementKind::tri3, 6, true);
    Interface interface = pair(structure, fluid);
    const auto field = [&](const Point& q) {
      return Point{each[0] + q[0], each[1] - q[1], each[2] + 2 * q[0]};
    };
    std::vector<double> forces(structure.points.size()), t(structure.points.size());
    interface.load.from_traction({fluid.points, {}}, sample(fluid, field), forces);
    ASSERT_TRUE(interface.load.recover_traction(forces, t).ok());
    EXPECT_LT(largest_difference(t, sample(structure, field)), 1e-10);
  }
  const Surface structure = disc(ElementKind::tri3, 6), fluid = two_sided_disc(8);
  Interface interface = pair(structure, fluid);
  std::vector<double> forces(structure.points.size()), t(structure.points.size());
  interface.load.from_traction({fluid.points, {}}, sample(fluid, [&](const Point&) { return each; }), forces);
  ASSERT_TRUE(interface.load.recover_traction(forces, t).ok());
  EXPECT_LT(largest_difference(t, sample(structure, [](const Point&) { return Point{1, -4, 6}; })), 1e-11);
}

TEST(RecoverTraction, IsZeroWhereNoFluidLies) {
  const Surface structure = plate(ElementKind::tri3, 8);
  const Surface fluid = grid(ElementKind::tri3, 6, [](double x, double y) { return Point{0.5 * x, y, 0}; });
  Interface interface = pair(structure, fluid);
  std::vector<double> forces(structure.points.size()), t(structure.points.size());
  interface.load.from_traction({fluid.points, {}}, std::vector<double>(fluid.points.size(), 1.0), forces);
  ASSERT_TRUE(interface.load.recover_traction(forces, t).ok());
  for (std::size_t i = 0; i < structure.node_count(); ++i) {
    if (structure.points[3 * i] > 0.95) {
      EXPECT_LT(std::abs(t[3 * i]), 0.02);
    }
    if (structure.points[3 * i] < 0.05) {
      EXPECT_NEAR(t[3 * i], 1, 0.02);
    }
  }
}

/// The conservative and the accurate at once: second order, where lumping nodal forces keeps errors of a
/// third.
TEST(RecoverTraction, ConvergesOnTheHemisphere) {
  double error[2];
  for (int level = 0; level < 2; ++level) {
    const Surface structure = octahedron_hemisphere(level ? 50 : 25),
                  fluid = lat_long_hemisphere(level ? 35 : 17);
    Interface interface = pair(structure, fluid);
    std::vector<double> forces(structure.points.size()), t(structure.points.size());
    interface.load.from_traction({fluid.points, {}}, sample(fluid, wavy), forces);
    ASSERT_TRUE(interface.load.recover_traction(forces, t).ok());
    error[level] = relative_error(t, sample(structure, wavy));
  }
  RecordProperty("errors", fmt::format("{:.3e} {:.3e}", error[0], error[1]));
  EXPECT_LT(error[1], 5e-3);
  EXPECT_GT(std::log2(error[0] / error[1]), 1.5);
}

/// A structure much finer than the fluid: every structure node still gets its share.
TEST(LoadTransfer, ACoarseFluidLoadsEveryNodeOfAFineStructure) {
  const Surface structure = plate(ElementKind::quad9, 12), fluid = plate(ElementKind::tri3, 2);
  Interface interface = pair(structure, fluid);
  const Loaded load = press(interface, fluid.points, std::vector<double>(fluid.node_count(), 1.0));
  for (std::size_t i = 0; i < structure.node_count(); ++i) EXPECT_GT(load.forces[3 * i + 2], 0);
  std::vector<double> t(structure.points.size());
  ASSERT_TRUE(interface.load.recover_traction(load.forces, t).ok());
  for (std::size_t i = 0; i < structure.node_count(); ++i) EXPECT_NEAR(t[3 * i + 2], 1, 1e-10);
}

} // namespace
} // namespace drogue::projection::test
