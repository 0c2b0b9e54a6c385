// SPDX-License-Identifier: GPL-3.0-or-later
//
// Axes of the principal stresses under homogeneous stretches, on sheets and bodies of every kind.
#include <gtest/gtest.h>

#include "structure_solver/fields.hpp"
#include "structure_solver/line_forces.hpp"
#include "tests/structure_solver/test_structures.hpp"

namespace drogue::structure {
namespace {

using mesh::ElementKind;

/// u = F X - X on all nodes.
std::vector<double> homogeneous(const Model& model, const Eigen::Matrix3d& F) {
  std::vector<double> u(model.equation_count());
  for (std::size_t i = 0; i < model.node_count(); ++i) {
    const Eigen::Vector3d X = Eigen::Map<const Eigen::Vector3d>(&model.mesh.points[3 * i]);
    Eigen::Map<Eigen::Vector3d> u_i(u.data() + 3 * i);
    u_i = F * X - X;
  }
  return u;
}

/// Every cell has this axis, whichever its sign.
void expect_axis(const std::vector<double>& axes, std::size_t cells, const Eigen::Vector3d& axis) {
  ASSERT_EQ(axes.size(), 3 * cells);
  for (std::size_t e = 0; e < cells; ++e) {
    const Eigen::Vector3d d = Eigen::Map<const Eigen::Vector3d>(&axes[3 * e]);
    EXPECT_NEAR(d.norm(), 1, 1e-12);
    EXPECT_NEAR(std::abs(d.dot(axis)), 1, 1e-12) << "cell " << e;
  }
}

/// A turn of space, and a stretch along an axis 30 degrees from x in the x-y plane with a contraction across
/// it.
struct Pull {
  Eigen::Matrix3d R = (Eigen::AngleAxisd(0.9, Eigen::Vector3d(1, 2, -1).normalized())).toRotationMatrix();
  Eigen::Vector3d along{std::cos(std::numbers::pi / 6), std::sin(std::numbers::pi / 6), 0};
  Eigen::Vector3d across{-along(1), along(0), 0};
  Eigen::Matrix3d stretch =
      Eigen::Matrix3d::Identity() + 0.3 * along * along.transpose() - 0.2 * across * across.transpose();
};

TEST(PrincipalAxes, OfMembranesTurnWithThem) {
  const Pull pull;
  for (const ElementKind kind :
       {ElementKind::tri3, ElementKind::tri6, ElementKind::quad4, ElementKind::quad9}) {
    SCOPED_TRACE(mesh::name(kind));
    Settings s;
    MembraneMaterial cloth;
    cloth.thickness = cloth.density = cloth.youngs_modulus = 1;
    cloth.poisson_ratio = 0.3;
    s.membranes = {{"cloth", cloth}};
    const Model model = test::model(s, test::sheet(kind, 2, 2, [](double x, double y) {
                                      return Eigen::Vector3d(x, y + 0.2 * x * y, 0);
                                    }));
    const StressFields f = stress_fields(model, homogeneous(model, pull.R * pull.stretch), 0);
    expect_axis(f.cell_largest_direction, f.cell_largest.size(), pull.R * pull.along);
    expect_axis(f.cell_smallest_direction, f.cell_largest.size(), pull.R * pull.across);
  }
}

TEST(PrincipalAxes, OfSolidsTurnWithThem) {
  const Pull pull;
  Settings s;
  s.solids = {{"body", {1, 1, 0.3}}};
  s.ignored_groups = {"skin"};
  const Model model = test::model(
      s, test::box(ElementKind::hex27, ElementKind::quad9, {1, 2, 1},
                   [](double x, double y, double z) { return Eigen::Vector3d(x + 0.1 * y * z, y, z); }));
  const StressFields f = stress_fields(model, homogeneous(model, pull.R * pull.stretch), 0);
  expect_axis(f.cell_largest_direction, f.cell_largest.size(), pull.R * pull.along);
  expect_axis(f.cell_smallest_direction, f.cell_largest.size(), pull.R * pull.across);
}

TEST(PrincipalAxes, OfALineIsItsOwn) {
  Settings s;
  LineMaterial wire;
  wire.area = wire.density = wire.youngs_modulus = 1;
  s.trusses = {{"line", wire, {}}};
  const Eigen::Vector3d to(1, -2, 2);
  const Model model = test::model(s, test::chain(3, Eigen::Vector3d::Zero(), to));
  const StressFields f = stress_fields(model, std::vector<double>(model.equation_count(), 0.0), 0);
  expect_axis(f.cell_largest_direction, 3, to / 3);
  EXPECT_EQ(f.cell_smallest_direction, std::vector<double>(9, 0.0));
}

/// A chain pulled apart at its second node: that node feels both lines, the group of all nodes none.
TEST(LineForces, AreTheTensionsOfTheLinesThatEndThere) {
  Settings s;
  LineMaterial wire;
  wire.area = 2, wire.density = wire.youngs_modulus = 1;
  s.trusses = {{"line", wire, {}}};
  s.line_forces = {{"middle", "line", "node"}};
  mesh::Mesh mesh = test::chain(3, Eigen::Vector3d::Zero(), Eigen::Vector3d(3, 0, 0));
  mesh.blocks.push_back({"node", ElementKind::point1, {1}});
  const Model model = test::model(s, mesh);
  std::vector<double> u(model.equation_count(), 0.0);
  u[3 * 1 + 1] = 1; // to (1, 1, 0): lines to (0, 0, 0) and (2, 0, 0), length sqrt(2) from 1
  const StressFields stress = stress_fields(model, u, 0);
  config::Report report;
  const auto forces = line_forces(s, model, report);
  ASSERT_TRUE(report.ok());
  ASSERT_EQ(forces.size(), 1U);
  ASSERT_EQ(forces[0].ends.size(), 2U);
  const auto force = forces[0](model, stress, u);
  const double tension = 2 * 0.5 * (2 - 1) * std::sqrt(2.0); // area, Green strain, stretch
  EXPECT_NEAR(force[0], 0, 1e-12);
  EXPECT_NEAR(force[1], -2 * tension / std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(force[2], 0, 1e-12);
}

TEST(LineForces, WithoutALineThatEndsThereAreRefused) {
  Settings s;
  LineMaterial wire;
  wire.area = wire.density = wire.youngs_modulus = 1;
  s.trusses = {{"line", wire, {}}};
  const Model model = test::model(s, test::chain(3, Eigen::Vector3d::Zero(), Eigen::Vector3d(3, 0, 0)));
  for (const LineForceSettings& wrong :
       {LineForceSettings{"a", "line", "line"}, LineForceSettings{"a", "lines", "line"},
        LineForceSettings{"a", "line", "nodes"}}) {
    s.line_forces = {wrong};
    config::Report report;
    (void)line_forces(s, model, report);
    EXPECT_FALSE(report.ok()) << wrong.group << " at " << wrong.at;
  }
}

} // namespace
} // namespace drogue::structure
