// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "coupler/projection/surface_integrals.hpp"
#include "coupler/projection/surface_tree.hpp"
#include "surfaces.hpp"

namespace drogue::projection::test {
namespace {

using Eigen::Vector3d;

constexpr ElementKind all_kinds[] = {ElementKind::tri3, ElementKind::tri6, ElementKind::quad4,
                                     ElementKind::quad9};

/// A gently curved, skewed patch.
Point curved(double x, double y) {
  return {x + 0.1 * y, y - 0.05 * x * y, 0.1 * x * x - 0.08 * y * x};
}

TEST(ClosestPoint, InvertsTheMapOfEveryKind) {
  for (const ElementKind kind : all_kinds) {
    Surface s = grid(kind, 1, curved);
    const Elements elements(s);
    const NodeMatrix X = gather(elements.nodes(0), s.points);
    for (const double xi : {0.1, 0.3, 0.55}) {
      for (const double eta : {0.05, 0.4}) {
        const auto shape = element_shape(kind, xi, eta);
        const Vector3d n = area_vector(shape, X).normalized();
        const Vector3d p = combine(shape.N, shape.nodes, X) + 0.01 * n;
        const ClosestPoint c = closest_point(kind, X, p);
        EXPECT_TRUE(c.inside);
        EXPECT_NEAR(c.xi, xi, 1e-10);
        EXPECT_NEAR(c.eta, eta, 1e-10);
        EXPECT_NEAR(std::sqrt(c.distance2), 0.01, 1e-12);
      }
    }
  }
}

/// Outside the element: no point of a fine lattice on it is nearer.
TEST(ClosestPoint, ClampsToTheElement) {
  for (const ElementKind kind : all_kinds) {
    Surface s = grid(kind, 1, curved);
    const NodeMatrix X = gather(Elements(s).nodes(0), s.points);
    for (const Vector3d& p :
         {Vector3d(1.4, 0.2, 0), Vector3d(-0.3, -0.2, 0.1), Vector3d(0.5, 1.3, 0), Vector3d(1.5, 1.4, 0)}) {
      const ClosestPoint c = closest_point(kind, X, p);
      EXPECT_FALSE(c.inside);
      double nearest = 1e9;
      const bool quad = fem::is_quadrilateral(kind);
      for (int i = 0; i <= 200; ++i) {
        for (int j = 0; j <= (quad ? 200 : 200 - i); ++j) {
          const auto shape = quad ? element_shape(kind, 0.01 * i - 1, 0.01 * j - 1)
                                  : element_shape(kind, 0.005 * i, 0.005 * j);
          nearest = std::min(nearest, (combine(shape.N, shape.nodes, X) - p).norm());
        }
      }
      EXPECT_LE(std::sqrt(c.distance2), nearest + 1e-12);
      EXPECT_GE(std::sqrt(c.distance2), nearest - 1e-3);
    }
  }
}

TEST(SurfaceTree, FindsWhatASearchOfAllElementsFinds) {
  for (Surface s : {octahedron_hemisphere(6), quad9_hemisphere(2)}) {
    const Elements elements(s);
    const SurfaceTree tree(elements, s.points);
    for (int i = 0; i < 60; ++i) {
      const Vector3d p(std::sin(7.0 * i), std::cos(3.0 * i), 0.9 * std::abs(std::sin(2.0 * i)));
      double nearest = 1e9;
      for (std::int32_t e = 0; e < elements.count(); ++e)
        nearest = std::min(nearest,
                           closest_point(elements.kind(e), gather(elements.nodes(e), s.points), p).distance2);
      EXPECT_EQ(tree.closest(p).point.distance2, nearest);
      EXPECT_EQ(tree.closest(p, i % elements.count()).point.distance2, nearest);
    }
  }
}

TEST(SurfaceTree, CountsLayers) {
  const Surface one = disc(ElementKind::tri3, 4), two = two_sided_disc(4);
  const Elements e1(one), e2(two);
  const SurfaceTree t1(e1, one.points), t2(e2, two.points);
  const Vector3d p(0.213, 0.117, 0);
  EXPECT_EQ(t1.layers(p, 1e-8), 1);
  EXPECT_EQ(t2.layers(p, 1e-8), 2);
  EXPECT_EQ(t1.layers(p + Vector3d(0, 0, 1e-3), 1e-8), 0);
}

TEST(MergeCoincident, JoinsWhatLiesWithinTheTolerance) {
  const std::vector<double> x{0, 0, 0, 1, 0, 0, 1e-10, -1e-10, 0, 1, 1e-3, 0};
  const Merged m = merge_coincident(x, 1e-9);
  EXPECT_EQ(m.count, 3);
  EXPECT_EQ(m.group, (std::vector<std::int32_t>{0, 1, 0, 2}));
}

TEST(Complete, RefusesWhatIsNoSurface) {
  const auto refused = [](Surface s) {
    const auto result = complete(s);
    return !result.ok() && result.error().kind == ErrorKind::config;
  };
  Surface good = plate(ElementKind::tri3, 2);
  EXPECT_FALSE(refused(good));
  EXPECT_TRUE(refused({}));
  Surface s = good;
  s.material = {0, 0, 0};
  EXPECT_TRUE(refused(s));
  s = good;
  s.points[4] = std::nan("");
  EXPECT_TRUE(refused(s));
  s = good;
  s.blocks[0].nodes[0] = 9;
  EXPECT_TRUE(refused(s));
  s = good;
  s.points.insert(s.points.end(), {5, 5, 5});
  EXPECT_TRUE(refused(s));
  s = good;
  s.reference.assign(s.points.size(), 0.0);
  EXPECT_TRUE(refused(s));
  s = good;
  s.blocks[0].kind = ElementKind::tet4;
  EXPECT_TRUE(refused(s));
}

// A surface's vector area is that of any other with the same rim: a hemisphere of facets has its equator's
// polygon's.
TEST(SurfaceIntegrals, VectorAreaIsThatOfTheRim) {
  const int m = 12;
  const Surface dome = lat_long_hemisphere(m);
  const Eigen::Vector3d area = vector_area(dome, dome.points);
  const double polygon = 0.5 * 4 * m * std::sin(2 * std::numbers::pi / (4 * m));
  EXPECT_NEAR(area.z(), polygon, 1e-12);
  EXPECT_NEAR(area.head<2>().norm(), 0, 1e-12);
  const Surface closed = sphere(6);
  EXPECT_NEAR(vector_area(closed, closed.points).norm(), 0, 1e-12);
  const Surface flat = plate(ElementKind::quad9, 3);
  std::vector<double> doubled = flat.points;
  for (double& x : doubled) x *= 2;
  EXPECT_NEAR(vector_area(flat, doubled).z(), 4, 1e-12);
}

TEST(SurfaceIntegrals, NormAndMeanOfFieldsOfEveryKind) {
  for (const ElementKind kind : all_kinds) {
    Surface s = plate(kind, 5);
    ASSERT_TRUE(complete(s).ok());
    const SurfaceIntegrals integrals(s);
    EXPECT_NEAR(integrals.area(), 1, 1e-14);
    const auto v = sample(s, [](const Point& p) { return Point{p[0], 2, p[0] - p[1]}; });
    EXPECT_NEAR(integrals.norm(v, 3), std::sqrt(1.0 / 3 + 4 + 1.0 / 6), 1e-13);
    std::array<double, 3> mean{};
    integrals.mean(v, 3, mean);
    EXPECT_NEAR(mean[0], 0.5, 1e-13);
    EXPECT_NEAR(mean[1], 2, 1e-13);
    EXPECT_NEAR(mean[2], 0, 1e-13);
    double sum = 0;
    for (const double w : integrals.lumped_area()) {
      EXPECT_GT(w, 0);
      sum += w;
    }
    EXPECT_NEAR(sum, 1, 1e-13);
  }
}

} // namespace
} // namespace drogue::projection::test
