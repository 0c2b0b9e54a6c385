// SPDX-License-Identifier: GPL-3.0-or-later
// Interfaces of plane problems: lines with two and three nodes.
#include <gtest/gtest.h>

#include <cmath>

#include "coupler/projection/line_refinement.hpp"
#include "coupler/projection/surface_integrals.hpp"
#include "surfaces.hpp"

namespace drogue::projection::test {
namespace {

using Eigen::Vector3d;

constexpr ElementKind lines[] = {ElementKind::line2, ElementKind::line3};

Point constant(const Point&) {
  return {1.25, -3, 0};
}
Point linear(const Point& p) {
  return {1 + 2 * p[0] - p[1], p[1] - 0.3 * p[0], 0};
}
/// Half a circle with the fluid inside, on the left of the direction.
Point arc(double s) {
  return {std::cos(std::numbers::pi * s), std::sin(std::numbers::pi * s), 0};
}
/// Unequal elements on [0, 1], middle nodes in the middle.
Surface uneven(ElementKind kind, int n) {
  Surface s = chain(kind, n, [](double t) {
    return Point{t + 0.1 * std::sin(2 * std::numbers::pi * t), 0, 0};
  });
  for (std::size_t i = 3; kind == ElementKind::line3 && i < s.points.size(); i += 6)
    s.points[i] = 0.5 * (s.points[i - 3] + s.points[i + 3]);
  return s;
}

std::vector<double> to_fluid(Interface& interface, const std::vector<double>& d_s) {
  std::vector<double> d_f(interface.fluid.points.size());
  EXPECT_TRUE(interface.field.apply(d_s, d_f).ok());
  return d_f;
}

TEST(Line, ClosestPointIsThatOfAFineLattice) {
  for (const ElementKind kind : lines) {
    const Surface s = chain(kind, 1, [](double t) { return Point{t, 0.3 * t * (1 - t), 0}; });
    const NodeMatrix X = gather(s.blocks[0].element(0), s.points);
    for (const Vector3d& p :
         {Vector3d(0.3, 0.2, 0), Vector3d(0.8, -0.1, 0), Vector3d(-0.4, 0.1, 0), Vector3d(1.7, 0, 0)}) {
      const ClosestPoint c = closest_point(kind, X, p);
      double nearest = 1e9;
      for (int i = 0; i <= 4000; ++i) {
        const auto shape = element_shape(kind, 0.0005 * i - 1, 0);
        nearest = std::min(nearest, (combine(shape.N, shape.nodes, X) - p).norm());
      }
      EXPECT_LE(std::sqrt(c.distance2), nearest + 1e-12);
      EXPECT_GE(std::sqrt(c.distance2), nearest - 1e-6);
      EXPECT_EQ(c.inside, p.x() > 0 && p.x() < 1);
    }
  }
}

TEST(Line, RefinementBreaksWhereTheOtherMeshHasItsNodes) {
  const Surface other = interval(ElementKind::line2, 7), one = interval(ElementKind::line2, 2);
  const Elements elements(other);
  const SurfaceTree tree(elements, other.points);
  const auto breaks = refine_line(ElementKind::line2, gather(one.blocks[0].element(0), one.points), tree);
  ASSERT_EQ(breaks.size(), 5u); // 1/7, 2/7 and 3/7 of [0, 1/2]
  for (int i = 1; i <= 3; ++i) EXPECT_NEAR(breaks[static_cast<std::size_t>(i)], 4.0 * i / 7 - 1, 1e-11);
  // The same element: no break.
  EXPECT_EQ(refine_line(ElementKind::line2, gather(elements.nodes(3), other.points), tree).size(), 2u);
}

TEST(LineProjection, ConstantsAreExactOnFacetsThatDoNotCoincide) {
  for (const ElementKind from : lines)
    for (const ElementKind to : lines) {
      const Surface structure = chain(from, 9, arc), fluid = chain(to, 14, arc);
      Interface interface = pair(structure, fluid);
      EXPECT_FALSE(interface.report.matching);
      EXPECT_LT(largest_difference(to_fluid(interface, sample(structure, constant)), sample(fluid, constant)),
                1e-13);
    }
}

TEST(LineProjection, LinearFieldsAreExactBetweenAllKinds) {
  for (const ElementKind from : lines)
    for (const ElementKind to : lines) {
      const Surface structure = uneven(from, 5), fluid = interval(to, 8);
      Interface interface = pair(structure, fluid);
      EXPECT_LT(largest_difference(to_fluid(interface, sample(structure, linear)), sample(fluid, linear)),
                1e-12);
    }
}

/// The defect of the projection is orthogonal to the fluid's shape functions: checked with a rule of its own
/// on the union of both meshes' nodes.
TEST(LineProjection, IsTheExactLeastSquares) {
  for (const ElementKind from : lines) {
    const Surface structure = uneven(from, 7), fluid = interval(ElementKind::line2, 5);
    Interface interface = pair(structure, fluid);
    const auto d_s = sample(structure, [](const Point& p) { return Point{std::sin(9 * p[0]), 0, 0}; });
    const auto d_f = to_fluid(interface, d_s);
    std::vector<double> nodes;
    for (const Surface* s : {&structure, &fluid})
      for (const std::int32_t i : s->blocks[0].nodes)
        nodes.push_back(s->points[3 * static_cast<std::size_t>(i)]);
    std::sort(nodes.begin(), nodes.end());
    const auto rule = element_quadrature(ElementKind::line2, 9);
    const auto value = [](const Surface& s, const std::vector<double>& d, double x) {
      for (std::int32_t e = 0; e < s.blocks[0].count(); ++e) {
        const NodeMatrix X = gather(s.blocks[0].element(e), s.points);
        if (x > X(0, 1)) continue;
        const ClosestPoint c = closest_point(s.blocks[0].kind, X, {x, 0, 0});
        const auto shape = element_shape(s.blocks[0].kind, c.xi, 0);
        return combine(shape.N, shape.nodes, gather(s.blocks[0].element(e), d)).x();
      }
      return 0.0;
    };
    std::vector<double> defect(fluid.node_count(), 0.0);
    for (std::size_t i = 1; i < nodes.size(); ++i) {
      const double half = 0.5 * (nodes[i] - nodes[i - 1]);
      for (const auto& q : rule) {
        const double x = 0.5 * (nodes[i] + nodes[i - 1]) + half * q.xi;
        const double difference = value(fluid, d_f, x) - value(structure, d_s, x);
        for (std::size_t a = 0; a < defect.size(); ++a) // hat functions
          defect[a] +=
              half * q.weight * std::max(0.0, 1 - 5 * std::abs(x - fluid.points[3 * a])) * difference;
      }
    }
    for (const double d : defect) EXPECT_NEAR(d, 0, 1e-12);
    EXPECT_GT(projection_defect(interface, d_s, d_f), 1e-3);
  }
}

TEST(LineProjection, ConvergesWithSecondOrderOnAnArc) {
  const auto field = [](const Point& p) {
    return Point{std::sin(4 * p[0]) * std::cos(3 * p[1]), p[1] * p[1], 0};
  };
  double displacement[2], traction[2];
  for (int level = 0; level < 2; ++level) {
    const Surface structure = chain(ElementKind::line2, level ? 96 : 48, arc),
                  fluid = chain(ElementKind::line2, level ? 132 : 66, arc);
    Interface interface = pair(structure, fluid);
    displacement[level] = relative_error(to_fluid(interface, sample(structure, field)), sample(fluid, field));
    std::vector<double> f(structure.points.size()), t(f.size());
    interface.load.from_traction({fluid.points, {}}, sample(fluid, field), f);
    ASSERT_TRUE(interface.load.recover_traction(f, t).ok());
    traction[level] = relative_error(t, sample(structure, field));
  }
  RecordProperty("errors", fmt::format("{:.3e} {:.3e} {:.3e} {:.3e}", displacement[0], displacement[1],
                                       traction[0], traction[1]));
  EXPECT_GT(std::log2(displacement[0] / displacement[1]), 1.9);
  EXPECT_GT(std::log2(traction[0] / traction[1]), 1.9);
  EXPECT_LT(displacement[1], 1e-3);
  EXPECT_LT(traction[1], 1e-3);
}

TEST(LineLoad, ForcesAddUpAndPushToTheRightOfTheDirection) {
  for (const ElementKind from : lines)
    for (const ElementKind to : lines) {
      const Surface structure = chain(from, 11, arc), fluid = chain(to, 15, arc);
      Interface interface = pair(structure, fluid);
      std::vector<double> x = fluid.points, p, f(structure.points.size());
      for (std::size_t i = 0; i < x.size(); i += 3) {
        x[i] *= 1.3; // an ellipse now
        p.push_back(2 + x[i] * x[i + 1]);
      }
      const LoadSums given = interface.load.from_pressure({x, {}}, p, f);
      const LoadSums received = sum_nodal(structure.points, f);
      EXPECT_LT((given.force - received.force).norm(), 1e-12 * given.force.norm());
      EXPECT_EQ(received.force.z(), 0);
      // Uniform pressure: the chord of length 2.6 turned outwards, upwards.
      const std::vector<double> uniform(fluid.node_count(), 3.0);
      EXPECT_LT((interface.load.from_pressure({x, {}}, uniform, f).force - Vector3d(0, 3 * 2.6, 0)).norm(),
                1e-12);
      EXPECT_LT((sum_nodal(structure.points, f).force - Vector3d(0, 3 * 2.6, 0)).norm(), 1e-12);
    }
}

TEST(LineLoad, RecoversLinearTractions) {
  for (const ElementKind kind : lines) {
    const Surface structure = uneven(kind, 6), fluid = interval(ElementKind::line2, 4);
    Interface interface = pair(structure, fluid);
    std::vector<double> f(structure.points.size()), t(f.size());
    interface.load.from_traction({fluid.points, {}}, sample(fluid, linear), f);
    ASSERT_TRUE(interface.load.recover_traction(f, t).ok());
    EXPECT_LT(largest_difference(t, sample(structure, linear)), 1e-11);
  }
}

/// A cable wetted on both sides: the fluid's nodes are doubled but for the ends.
Surface two_sided_line(int n) {
  Surface s = interval(ElementKind::line2, n);
  mesh::ElementBlock back{"back", ElementKind::line2, {}};
  const auto twin = [n](int i) { return i == 0 || i == n ? i : n + i; };
  for (int i = 1; i < n; ++i) s.points.insert(s.points.end(), {static_cast<double>(i) / n, 0, 0});
  for (int i = n; i > 0; --i) back.nodes.insert(back.nodes.end(), {twin(i), twin(i - 1)});
  s.blocks.push_back(std::move(back));
  return s;
}

TEST(LineLoad, BothSidesOfACableAddUpAndMatchingMeshesAreCopied) {
  for (const int n : {6, 9}) {
    const Surface cable = interval(ElementKind::line2, 6), fluid = two_sided_line(n);
    Interface interface = pair(cable, fluid);
    EXPECT_EQ(interface.report.fluid_sides, 2);
    EXPECT_EQ(interface.report.matching, n == 6);
    const auto d_f = to_fluid(interface, sample(cable, linear));
    EXPECT_LT(largest_difference(d_f, sample(fluid, linear)), n == 6 ? 0.0 + 1e-300 : 1e-12);
    std::vector<double> p(fluid.node_count(), 1.0), f(cable.points.size());
    for (const std::int32_t node : fluid.blocks[1].nodes) p[static_cast<std::size_t>(node)] = 5.0;
    p[0] = p[static_cast<std::size_t>(n)] = 3.0;
    interface.load.from_pressure({fluid.points, {}}, p, f);
    // The first side lies above (its normal points down) with 1, the other below with 5; 3 at both ends.
    EXPECT_NEAR(sum_nodal(cable.points, f).force.y(), 4.0 * (1 - 1.0 / n), 1e-12);
  }
}

TEST(LineIntegrals, LengthMeanAndVectorArea) {
  Surface half = chain(ElementKind::line3, 20, arc);
  ASSERT_TRUE(complete(half).ok());
  const SurfaceIntegrals integrals(half);
  EXPECT_NEAR(integrals.area(), std::numbers::pi, 1e-5);
  EXPECT_LT((vector_area(half, half.points) - Vector3d(0, 2, 0)).norm(), 1e-12);
  double sum = 0;
  for (const double area : integrals.lumped_area()) sum += area;
  EXPECT_NEAR(sum, integrals.area(), 1e-12);
}

TEST(LineSurface, RefusesWhatIsNoPlaneInterface) {
  const auto message = [](Surface structure, Surface fluid) {
    const auto made = make_interface(std::move(structure), std::move(fluid), {});
    return made ? std::string() : made.error().message;
  };
  const Surface good = interval(ElementKind::line2, 4);
  EXPECT_EQ(message(good, interval(ElementKind::line3, 3)), "");
  Surface bent = good;
  bent.points[5] = 0.1;
  EXPECT_NE(message(bent, good).find("node 1 lies outside the plane z = 0"), std::string::npos);
  EXPECT_NE(message(plate(ElementKind::tri3, 2), good).find("faces"), std::string::npos);
  Surface mixed = plate(ElementKind::tri3, 2);
  mixed.blocks.push_back({"edge", ElementKind::line2, {0, 1}});
  EXPECT_NE(message(mixed, good).find("must be made of faces or of lines"), std::string::npos);
  Surface point = good;
  point.points = {0, 0, 0, 0, 0, 0, 0.5, 0, 0, 0.7, 0, 0, 1, 0, 0};
  EXPECT_NE(message(point, good).find("element 0 has no area"), std::string::npos);
  Surface apart = good;
  for (std::size_t i = 1; i < apart.points.size(); i += 3) apart.points[i] = 0.5;
  EXPECT_NE(message(good, apart).find("do not lie on one another"), std::string::npos);
}

} // namespace
} // namespace drogue::projection::test
