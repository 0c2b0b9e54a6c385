// SPDX-License-Identifier: GPL-3.0-or-later
//
// Meshes of every kind: patch test, closed surfaces under pressure, mass; and what a model refuses.
#include <gtest/gtest.h>

#include "structure_solver/assembly.hpp"
#include "tests/structure_solver/test_structures.hpp"

namespace drogue::structure {
namespace {

using mesh::ElementKind;

constexpr ElementKind surface_kinds[] = {ElementKind::tri3, ElementKind::tri6, ElementKind::quad4,
                                         ElementKind::quad9};

/// A bend of the unit square or cube that moves inner nodes off the straight lines.
Eigen::Vector3d bent(double x, double y, double z) {
  return {x + 0.06 * std::sin(3 * y + 2 * z), y + 0.05 * std::sin(4 * x + z),
          z + 0.07 * std::sin(3 * x - 2 * y)};
}

/// The unit square, its inner nodes moved.
Eigen::Vector3d stirred_square(double x, double y) {
  const double inside = x * (1 - x) * y * (1 - y);
  return {x + 0.9 * inside * std::cos(5 * y), y - 0.8 * inside * std::cos(4 * x), 0};
}
Eigen::Vector3d stirred_cube(double x, double y, double z) {
  const double inside = x * (1 - x) * y * (1 - y) * z * (1 - z);
  return {x + 3 * inside * std::cos(5 * y), y - 3 * inside * std::cos(4 * z),
          z + 3 * inside * std::cos(6 * x)};
}

LoadValues loads_of(const Model& model) {
  auto loads = evaluate_loads(model, 0);
  EXPECT_TRUE(loads);
  return loads ? std::move(*loads) : LoadValues{};
}

/// A homogeneous deformation leaves every inner node in equilibrium, at any size.
void expect_patch(const Model& model, const std::string& boundary, const Eigen::Matrix3d& F) {
  std::vector<double> u(model.equation_count()), r(model.equation_count());
  for (std::size_t i = 0; i < model.node_count(); ++i) {
    const Eigen::Vector3d X = Eigen::Map<const Eigen::Vector3d>(&model.mesh.points[3 * i]);
    Eigen::Map<Eigen::Vector3d> u_i(u.data() + 3 * i);
    u_i = F * X - X;
  }
  Assembler assembler(model);
  const double energy =
      assembler.assemble({.displacement = u, .load_displacement = u, .loads = loads_of(model)}, r);
  std::vector<bool> outer(model.node_count(), false);
  for (const std::int32_t node : model.mesh.nodes_of(boundary)) outer[static_cast<std::size_t>(node)] = true;
  double inner_force = 0, outer_force = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    double& largest = outer[i / 3] ? outer_force : inner_force;
    largest = std::max(largest, std::abs(r[i]));
  }
  EXPECT_LT(inner_force, 1e-13 * outer_force);
  // Uniform strain energy density of St. Venant-Kirchhoff on unit volume or area.
  const Eigen::Matrix3d E = 0.5 * (F.transpose() * F - Eigen::Matrix3d::Identity());
  const double lambda = 1.4e6 * 0.4 / (1.4 * 0.2), mu = 5e5;
  const bool solid = std::visit(
      [](const auto& b) { return std::is_same_v<std::decay_t<decltype(b.material)>, SolidMaterial>; },
      model.batches[0]);
  if (solid) {
    EXPECT_NEAR(energy, 0.5 * lambda * E.trace() * E.trace() + mu * E.squaredNorm(), 1e-12 * energy);
  }
}

TEST(Patch, Membranes) {
  Eigen::Matrix3d F;
  F << 1.2, 0.1, 0, -0.2, 0.9, 0, 0.4, 0.3, 1;
  for (const ElementKind kind : surface_kinds) {
    SCOPED_TRACE(mesh::name(kind));
    Settings s;
    s.membranes = {{"cloth", {0.01, 1, 1.4e6, 0.4, 100}}};
    const Model model = test::model(s, test::sheet(kind, 2, 2, stirred_square));
    expect_patch(model, "edge", F);
  }
}

TEST(Patch, PlaneStrain) {
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F.topLeftCorner<2, 2>() << 1.2, 0.1, -0.2, 0.9;
  for (const ElementKind kind : {ElementKind::tri6, ElementKind::quad9}) {
    SCOPED_TRACE(mesh::name(kind));
    Settings s;
    s.plane = true;
    s.solids = {{"cloth", {1, 1.4e6, 0.4}}};
    expect_patch(test::model(s, test::sheet(kind, 2, 2, stirred_square)), "edge", F);
  }
}

TEST(Patch, Volumes) {
  Eigen::Matrix3d F;
  F << 1.2, 0.1, 0.3, -0.2, 0.9, 0, 0.4, 0.3, 1.1;
  for (const ElementKind kind : {ElementKind::tet10, ElementKind::hex27}) {
    SCOPED_TRACE(mesh::name(kind));
    Settings s;
    s.solids = {{"body", {1, 1.4e6, 0.4}}};
    s.ignored_groups = {"skin"};
    expect_patch(test::model(s, test::box(kind, ElementKind::quad9, {2, 2, 2}, stirred_cube)), "boundary", F);
  }
}

/// No net force and no net moment on a closed surface, whatever its shape.
void expect_closed(const Model& model) {
  std::vector<double> r(model.equation_count());
  const std::vector<double> u(model.equation_count(), 0.0);
  Assembler assembler(model);
  assembler.external_force(u, loads_of(model), r);
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = force;
  double size = 0;
  for (std::size_t i = 0; i < model.node_count(); ++i) {
    const Eigen::Vector3d f = Eigen::Map<const Eigen::Vector3d>(&r[3 * i]);
    force += f;
    moment += Eigen::Map<const Eigen::Vector3d>(&model.mesh.points[3 * i]).cross(f);
    size += f.norm();
  }
  EXPECT_GT(size, 1);
  EXPECT_LT(force.norm(), 1e-14 * size);
  EXPECT_LT(moment.norm(), 1e-14 * size);
}

TEST(Closure, SurfacesOfEveryKind) {
  for (const ElementKind kind : surface_kinds) {
    SCOPED_TRACE(mesh::name(kind));
    Settings s;
    s.solids = {{"body", {1, 1, 0.3}}};
    s.pressures = {{"skin", test::expression("3")}};
    const Model model = test::model(s, test::box(ElementKind::hex27, kind, {2, 1, 2}, bent));
    expect_closed(model);
  }
}

TEST(Closure, EdgesOfEveryKind) {
  const int n = 8;
  for (const ElementKind kind : {ElementKind::line2, ElementKind::line3}) {
    SCOPED_TRACE(mesh::name(kind));
    mesh::Mesh mesh = test::sheet(ElementKind::quad9, n / 2, n / 2, [](double x, double y) {
      Eigen::Vector3d X = bent(x, y, 0);
      X(2) = 0;
      return X;
    });
    std::vector<std::int32_t> ring; // counter-clockwise
    for (int i = 0; i < n; ++i) ring.push_back(i);
    for (int j = 0; j < n; ++j) ring.push_back(j * (n + 1) + n);
    for (int i = n; i > 0; --i) ring.push_back(n * (n + 1) + i);
    for (int j = n; j > 0; --j) ring.push_back(j * (n + 1));
    ring.push_back(0);
    mesh::ElementBlock rim{"rim", kind, {}};
    const std::size_t stride = kind == ElementKind::line2 ? 1 : 2;
    for (std::size_t k = 0; k + 1 < ring.size(); k += stride) {
      rim.nodes.push_back(ring[k]);
      rim.nodes.push_back(ring[k + stride]);
      if (stride == 2) rim.nodes.push_back(ring[k + 1]);
    }
    mesh.blocks.push_back(std::move(rim));
    Settings s;
    s.plane = true;
    s.solids = {{"cloth", {1, 1, 0.3}}};
    s.pressures = {{"rim", test::expression("3")}};
    const Model model = test::model(s, std::move(mesh));
    expect_closed(model);
    // Outward: the middle of the lower edge is pushed down.
    std::vector<double> r(model.equation_count());
    Assembler assembler(model);
    assembler.external_force(std::vector<double>(r.size(), 0.0), loads_of(model), r);
    EXPECT_LT(r[3 * 4 + 1], 0);
  }
}

TEST(Traction, AddsUpToItsAreaOnFacesAndEdges) {
  const auto total = [](const Model& model, std::size_t component) {
    const LoadValues loads = loads_of(model);
    double sum = 0;
    for (std::size_t i = component; i < loads.force.size(); i += 3) sum += loads.force[i];
    return sum;
  };
  Settings s;
  s.solids = {{"body", {1, 1, 0.3}}};
  s.tractions = {{"skin", test::vector("0", "0", "2")}};
  const auto brick = [](double x, double y, double z) { return Eigen::Vector3d(2 * x, 3 * y, z); };
  for (const ElementKind kind : surface_kinds)
    EXPECT_NEAR(total(test::model(s, test::box(ElementKind::tet10, kind, {1, 1, 1}, brick)), 2), 2 * 22.0,
                1e-12);
  s.plane = true;
  s.solids = {{"cloth", {1, 1, 0.3}}};
  s.tractions = {{"side", test::vector("5", "0", "0")}};
  mesh::Mesh sheet =
      test::sheet(ElementKind::tri6, 1, 1, [](double x, double y) { return Eigen::Vector3d(x, 3 * y, 0); });
  sheet.blocks.push_back({"side", ElementKind::line3, {2, 8, 5}});
  EXPECT_NEAR(total(test::model(s, std::move(sheet)), 0), 15, 1e-13);
}

TEST(Mass, IsThatOfTheBodyAndPositive) {
  for (const ElementKind kind : {ElementKind::tet10, ElementKind::hex27}) {
    Settings s;
    s.solids = {{"body", {2.5, 1, 0.3}}};
    s.ignored_groups = {"skin"};
    const Model model =
        test::model(s, test::box(kind, ElementKind::tri3, {2, 1, 1}, [](double x, double y, double z) {
                      return Eigen::Vector3d(2 * x, 3 * y + x, z);
                    }));
    double mass = 0;
    for (const double m : model.mass) {
      EXPECT_GT(m, 0);
      mass += m;
    }
    EXPECT_NEAR(mass, 2.5 * 6, 1e-12);
  }
}

/// What build_model says about a mesh.
std::string refusal(const Settings& s, mesh::Mesh mesh) {
  config::Report report;
  EXPECT_FALSE(build_model(s, std::move(mesh), report));
  std::string text;
  for (const auto& line : report.lines()) text += line + '\n';
  return text;
}

Eigen::Vector3d flat(double x, double y) {
  return {x, y, 0};
}

TEST(Refusal, AMaterialThatCannotTakeTheKind) {
  Settings s;
  s.solids = {{"cloth", {1, 1, 0.3}}};
  EXPECT_NE(refusal(s, test::sheet(ElementKind::quad9, 1, 1, flat))
                .find("group \"cloth\" holds 9-node quadrilateral elements; 10-node tetrahedron or 27-node "
                      "hexahedron elements are needed here"),
            std::string::npos);
  s.plane = true;
  EXPECT_NE(
      refusal(s, test::sheet(ElementKind::tri3, 1, 1, flat)).find("6-node triangle or 9-node quadrilateral"),
      std::string::npos);
}

TEST(Refusal, IrregularElementsByNumberAndGroup) {
  Settings s;
  s.plane = true;
  s.solids = {{"cloth", {1, 1, 0.3}}};
  mesh::Mesh inverted = test::sheet(ElementKind::quad9, 2, 2, flat);
  auto& nodes = inverted.blocks[0].nodes;
  std::swap(nodes[9 * 2 + 0], nodes[9 * 2 + 1]); // element 2 runs clockwise
  EXPECT_NE(refusal(s, std::move(inverted)).find("element 2 of group \"cloth\""), std::string::npos);

  Settings cloth;
  cloth.membranes = {{"cloth", {1, 1, 1, 0.3, 0}}};
  mesh::Mesh thin = test::sheet(ElementKind::tri3, 1, 1, flat);
  thin.blocks[0].nodes[3 * 5 + 1] = thin.blocks[0].nodes[3 * 5];
  const std::string text = refusal(cloth, std::move(thin));
  EXPECT_NE(text.find("element 5 of group \"cloth\""), std::string::npos) << text;
  EXPECT_NE(text.find("is degenerate"), std::string::npos) << text;

  Settings rope;
  rope.cables = {{"line", {1, 1, 1, 0, StrainMeasure::green, true}, {}}};
  mesh::Mesh chain = test::chain(3, {0, 0, 0}, {1, 0, 0});
  chain.points[3] = 0;
  EXPECT_NE(refusal(rope, std::move(chain)).find("element 0 of group \"line\""), std::string::npos);
}

TEST(Refusal, APlaneProblemOutOfItsPlane) {
  Settings s;
  s.plane = true;
  s.solids = {{"cloth", {1, 1, 0.3}}};
  EXPECT_NE(refusal(s, test::sheet(ElementKind::quad9, 1, 1,
                                   [](double x, double y) { return Eigen::Vector3d(x, y, 0.1 * x); }))
                .find("outside the plane"),
            std::string::npos);
}

TEST(Refusal, FacesOfNothing) {
  Settings s;
  s.pressures = {{"cloth", test::expression("1")}};
  EXPECT_NE(refusal(s, test::sheet(ElementKind::quad9, 1, 1, flat)).find("is free but has no mass"),
            std::string::npos);
}

} // namespace
} // namespace drogue::structure
