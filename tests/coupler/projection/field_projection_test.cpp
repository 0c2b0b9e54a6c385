// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "common/fem/quadrature.hpp"
#include "surfaces.hpp"

namespace drogue::projection::test {
namespace {

std::vector<double> to_fluid(Interface& interface, const std::vector<double>& d_s) {
  std::vector<double> d_f(interface.fluid.points.size());
  EXPECT_TRUE(interface.field.apply(d_s, d_f).ok());
  return d_f;
}

Point constant(const Point&) {
  return {1.25, -3, 0.5};
}
Point linear(const Point& p) {
  return {1 + 2 * p[0] - p[1], p[1] + 0.3 * p[2], -4 * p[0]};
}

TEST(FieldProjection, ConstantsAreExact) {
  const Surface structures[] = {octahedron_hemisphere(9), quad9_hemisphere(3), sphere(5)};
  const Surface fluids[] = {lat_long_hemisphere(8), lat_long_hemisphere(11), octahedron_hemisphere(7)};
  for (int i = 0; i < 3; ++i) {
    Interface interface = pair(structures[i], fluids[i], {.largest_gap = 0.1});
    const auto d_f = to_fluid(interface, sample(structures[i], constant));
    EXPECT_LT(largest_difference(d_f, sample(fluids[i], constant)), 1e-13) << i;
  }
}

TEST(FieldProjection, LinearFieldsAreExactBetweenAllKindsOnAPlane) {
  constexpr ElementKind kinds[] = {ElementKind::tri3, ElementKind::tri6, ElementKind::quad4,
                                   ElementKind::quad9};
  for (const ElementKind from : kinds) {
    for (const ElementKind to : kinds) {
      const Surface structure = plate(from, 4), fluid = plate(to, 7);
      Interface interface = pair(structure, fluid);
      EXPECT_FALSE(interface.report.matching);
      EXPECT_LT(interface.report.largest_gap, 1e-14);
      const auto d_f = to_fluid(interface, sample(structure, linear));
      EXPECT_LT(largest_difference(d_f, sample(fluid, linear)), 1e-12);
    }
  }
}

double hemisphere_error(const Surface& structure, int m) {
  const Surface fluid = lat_long_hemisphere(m);
  Interface interface = pair(structure, fluid);
  return relative_error(to_fluid(interface, sample(structure, wavy)), sample(fluid, wavy));
}

/// Second order on linear triangles, and better than nearest projection (1.35e-3 at 5,000 nodes, 3.41e-4 at
/// 20,000).
TEST(FieldProjection, ConvergesOnTheHemisphereFromTriangles) {
  const double e1 = hemisphere_error(octahedron_hemisphere(25), 17);
  const double e2 = hemisphere_error(octahedron_hemisphere(50), 35);
  const double e3 = hemisphere_error(octahedron_hemisphere(100), 70);
  RecordProperty("errors", fmt::format("{:.3e} {:.3e} {:.3e}", e1, e2, e3));
  EXPECT_LT(e2, 1.35e-3);
  EXPECT_LT(e3, 3.41e-4);
  EXPECT_GT(e3, 1e-6);
  EXPECT_GT(std::log2(e2 / e3), 1.8);
}

/// sqrt(int |d - exact|^2 / int |exact|^2) over triangles inscribed in the unit sphere, exact taken radially
/// above.
double sphere_l2_error(const Surface& fluid, const std::vector<double>& d) {
  const Elements elements(fluid);
  double difference = 0, size = 0;
  for (std::int32_t e = 0; e < elements.count(); ++e) {
    const NodeMatrix X = gather(elements.nodes(e), fluid.points), D = gather(elements.nodes(e), d);
    for (const fem::SurfacePoint& q : fem::surface_quadrature(elements.kind(e), 5)) {
      const auto shape = element_shape(elements.kind(e), q.xi, q.eta);
      const Eigen::Vector3d x = combine(shape.N, shape.nodes, X).normalized();
      const Point w = wavy({x[0], x[1], x[2]});
      const Eigen::Vector3d exact(w[0], w[1], w[2]);
      const double da = q.weight * area_vector(shape, X).norm();
      difference += da * (combine(shape.N, shape.nodes, D) - exact).squaredNorm();
      size += da * exact.squaredNorm();
    }
  }
  return std::sqrt(difference / size);
}

/// Least squares is the best approximation: with a source as accurate as Q9, nearer in L2 than even the exact
/// nodal values of the fluid's linear triangles; second order.
TEST(FieldProjection, FromQ9IsBetterInL2ThanTheExactNodalValues) {
  double error[2];
  for (int level = 0; level < 2; ++level) {
    const Surface structure = quad9_hemisphere(level ? 10 : 5), fluid = lat_long_hemisphere(level ? 35 : 17);
    Interface interface = pair(structure, fluid);
    error[level] = sphere_l2_error(fluid, to_fluid(interface, sample(structure, wavy)));
    EXPECT_LT(error[level], 0.8 * sphere_l2_error(fluid, sample(fluid, wavy)));
  }
  RecordProperty("errors", fmt::format("{:.3e} {:.3e}", error[0], error[1]));
  EXPECT_LT(error[1], 1.35e-3);
  EXPECT_GT(std::log2(error[0] / error[1]), 1.8);
}

TEST(FieldProjection, ReportsWhatItMisses) {
  const Surface q9 = plate(ElementKind::quad9, 4), t3 = plate(ElementKind::tri3, 7);
  Interface interface = pair(q9, t3);
  auto d_s = sample(q9, linear);
  EXPECT_LT(projection_defect(interface, d_s, to_fluid(interface, d_s)), 1e-13);
  // x^2: the nearest piecewise linear function misses h^2/6 of it, and any other one more.
  d_s = sample(q9, [](const Point& p) { return Point{p[0] * p[0], 0, 0}; });
  auto d_f = to_fluid(interface, d_s);
  const double least = projection_defect(interface, d_s, d_f);
  EXPECT_NEAR(least, 1.0 / (49 * 6), 0.01 / (49 * 6));
  d_f[3 * 20] += 1e-3;
  EXPECT_GT(projection_defect(interface, d_s, d_f), least);
  const std::vector<double> none(d_s.size(), 0.0);
  EXPECT_EQ(projection_defect(interface, none, to_fluid(interface, none)), 0);
}

TEST(FieldProjection, MatchingMeshesAreCopied) {
  const Surface structure = disc(ElementKind::tri3, 6), fluid = two_sided_disc(6);
  Interface interface = pair(structure, fluid);
  EXPECT_TRUE(interface.report.matching);
  EXPECT_EQ(interface.report.fluid_sides, 2);
  const auto d_f = to_fluid(interface, sample(structure, wavy));
  EXPECT_EQ(d_f, sample(fluid, wavy)); // to the bit
  EXPECT_FALSE(pair(plate(ElementKind::tri3, 4, true), plate(ElementKind::tri3, 4)).report.matching);
}

TEST(FieldProjection, BothSidesOfACanopyMoveAsOne) {
  const Surface structure = disc(ElementKind::quad9, 6), fluid = two_sided_disc(16);
  Interface interface = pair(structure, fluid);
  EXPECT_FALSE(interface.report.matching);
  EXPECT_EQ(interface.report.fluid_sides, 2);
  const auto d_f = to_fluid(interface, sample(structure, wavy));
  const auto twin = other_side(fluid);
  for (std::size_t i = 0; i < fluid.node_count(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(d_f[3 * i + k], d_f[3 * static_cast<std::size_t>(twin[i]) + k]);
  EXPECT_LT(relative_error(d_f, sample(fluid, wavy)), 0.05);
  EXPECT_GT(relative_error(d_f, sample(fluid, wavy)), 1e-6);
}

/// A strip [0, 2] x [0, 1] folded at x = 1: its layers coincide in space, and material coordinates tell them
/// apart.
Surface folded(ElementKind kind, int n, bool with_material) {
  Surface s = grid(kind, n, [](double x, double y) { return Point{2 * x, y, 0}; });
  if (with_material) s.material = s.points;
  for (std::size_t i = 0; i < s.points.size(); i += 3) s.points[i] = std::min(s.points[i], 2 - s.points[i]);
  return s;
}

TEST(FieldProjection, MaterialCoordinatesTellCoincidentLayersApart) {
  const auto along = [](const Surface& s) { // 0 to 2 along the strip
    std::vector<double> d;
    for (std::size_t i = 0; i < s.material.size(); i += 3)
      d.insert(d.end(), {s.material[i], s.material[i + 1], 1});
    return d;
  };
  const Surface structure = folded(ElementKind::quad9, 4, true), fluid = folded(ElementKind::tri3, 6, true);
  Interface interface = pair(structure, fluid);
  EXPECT_LT(largest_difference(to_fluid(interface, along(structure)), along(fluid)), 1e-12);
  Interface blind = pair(folded(ElementKind::quad9, 4, false), folded(ElementKind::tri3, 6, false));
  EXPECT_GT(largest_difference(to_fluid(blind, along(structure)), along(fluid)), 0.5);
}

TEST(MatchReport, ShowsGapNormalsAndDryArea) {
  Surface raised = plate(ElementKind::tri3, 5);
  for (std::size_t i = 0; i < raised.points.size(); i += 3)
    raised.points[i + 2] = 0.01 + 0.005 * raised.points[i];
  const MatchReport r = pair(plate(ElementKind::quad9, 3), raised).report;
  EXPECT_EQ(r.unmatched_points, 0);
  EXPECT_NEAR(r.largest_gap, 0.015 / std::sqrt(2.0), 2e-4);
  EXPECT_NEAR(r.worst_normal_angle, std::atan(0.005) * 180 / std::numbers::pi, 1e-6);
  EXPECT_EQ(r.dry_area, 0);
  Surface half = grid(ElementKind::tri3, 4, [](double x, double y) { return Point{0.5 * x, y, 0}; });
  EXPECT_NEAR(pair(plate(ElementKind::tri3, 4), half).report.dry_area, 0.5, 1e-12);
}

TEST(MatchReport, SurfacesApartAreRefusedWithAReason) {
  Surface far = plate(ElementKind::tri3, 5);
  for (std::size_t i = 0; i < far.points.size(); i += 3) far.points[i + 2] = 0.2;
  far.name = "fluid";
  const auto result = make_interface(plate(ElementKind::tri3, 4), far, {});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().kind, ErrorKind::config);
  EXPECT_NE(result.error().message.find("300 of 300 points"), std::string::npos) << result.error().message;
  EXPECT_NE(result.error().message.find("projection.largest_gap"), std::string::npos);
  EXPECT_TRUE(make_interface(plate(ElementKind::tri3, 4), far, {.largest_gap = 0.2}).ok());
  EXPECT_FALSE(make_interface(plate(ElementKind::tri3, 4), far, {.largest_gap = 0}).ok());
}

} // namespace
} // namespace drogue::projection::test
