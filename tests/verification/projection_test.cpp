// SPDX-License-Identifier: GPL-3.0-or-later
// Least-squares projection between two meshes of the unit hemisphere that match nowhere: the structure's, an
// octahedron split n times (or Q9 patches on it), and the fluid's, rings of equal latitude. Both are
// inscribed in the sphere, with facets of their own. Fields: (f(x,y,z), f(y,z,x), f(z,x,y)), f = sin 4x cos
// 3y + z, and Franke's function in three dimensions. Errors: sqrt(sum |ours - exact|^2 / sum |exact|^2) over
// the nodes.
//
// Bounds from 5,000 nodes on; at 1,000 four times those, of second order. Displacement: what the
// nearest-projection mapping of preCICE 3.4.1 reaches on the same pair and field (measured). Traction: of the
// size of that mapping's consistent form, which conserves nothing; ours is the density of forces that add up
// to the fluid's.
#include <cmath>

#include "coupler/projection/interface.hpp"
#include "coupler/projection/surface_integrals.hpp"
#include "tests/coupler/projection/surfaces.hpp"
#include "tests/support/verify.hpp"

namespace drogue::projection::test {
namespace {

using drogue::test::verify;
using drogue::test::verify_between;
using Field = std::function<Point(const Point&)>;

struct Level {
  const char* name;
  int splits, rings, patches; ///< patches: Q9 elements along a third of a face, with about as many nodes
  double displacement, traction;
};
#ifdef DROGUE_FINE
constexpr Level levels[] = {{"20k", 100, 70, 21, 3.41e-4, 6e-4}, {"80k", 200, 141, 41, 8.60e-5, 2e-4}};
#else
constexpr Level levels[] = {{"1k", 25, 18, 5, 5.4e-3, 8e-3}, {"5k", 50, 35, 10, 1.35e-3, 2e-3}};
#endif

/// Franke's function of three variables, in each component with its arguments in turn.
Point franke(const Point& p) {
  const auto bell = [](double a, double b, double c) { return a * a + b * b + c * c; };
  const auto f = [&](double x, double y, double z) {
    return 0.75 * std::exp(-bell(9 * x - 2, 9 * y - 2, 9 * z - 2) / 4) +
           0.75 * std::exp(-(9 * x + 1) * (9 * x + 1) / 49 - (9 * y + 1) / 10 - (9 * z + 1) / 10) +
           0.5 * std::exp(-bell(9 * x - 7, 9 * y - 3, 9 * z - 5) / 4) -
           0.2 * std::exp(-bell(9 * x - 4, 9 * y - 7, 9 * z - 5));
  };
  return {f(p[0], p[1], p[2]), f(p[1], p[2], p[0]), f(p[2], p[0], p[1])};
}

Point constant(const Point&) {
  return {1.25, -3, 0.5};
}

double displacement_error(Interface& pair, const Field& field) {
  std::vector<double> d_f(pair.fluid.points.size());
  EXPECT_TRUE(pair.field.apply(sample(pair.structure, field), d_f).ok());
  return relative_error(d_f, sample(pair.fluid, field));
}

struct Load {
  double error = 0;         ///< of the recovered traction
  double force_defect = 0;  ///< of the nodal forces against int t dA over the fluid, relative to sum |f|
  double moment_defect = 0; ///< of their moment, relative to the largest lever times sum |f|
};

/// The exact integral of a nodal field over flat triangles: independent of the projection's points.
Eigen::Vector3d integral(const Surface& surface, const std::vector<double>& t) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const Elements elements(surface);
  for (std::int32_t e = 0; e < elements.count(); ++e) {
    const NodeMatrix X = gather(elements.nodes(e), surface.points), T = gather(elements.nodes(e), t);
    const double area = 0.5 * (X.col(1) - X.col(0)).cross(X.col(2) - X.col(0)).norm();
    sum += area / 3 * (T.col(0) + T.col(1) + T.col(2));
  }
  return sum;
}

Load load(Interface& pair, const Field& field) {
  const std::vector<double> t_f = sample(pair.fluid, field);
  std::vector<double> f(pair.structure.points.size()), t_s(f.size());
  const LoadSums given = pair.load.from_traction({pair.fluid.points, {}}, t_f, f);
  EXPECT_TRUE(pair.load.recover_traction(f, t_s).ok());
  const LoadSums received = sum_nodal(pair.structure.points, f);
  double magnitude = 0;
  for (std::size_t i = 0; i < f.size(); i += 3) magnitude += std::hypot(f[i], f[i + 1], f[i + 2]);
  return {relative_error(t_s, sample(pair.structure, field)),
          (received.force - integral(pair.fluid, t_f)).norm() / magnitude,
          (received.moment - given.moment).norm() / magnitude};
}

/// int t dA of the recovered traction over the structure's own facets, against the sum of the forces: what a
/// solver that takes the traction makes of it. The areas of the two surfaces differ by O(h^2).
double recovered_force_defect(Interface& pair, const Field& field) {
  std::vector<double> f(pair.structure.points.size()), t_s(f.size());
  pair.load.from_traction({pair.fluid.points, {}}, sample(pair.fluid, field), f);
  EXPECT_TRUE(pair.load.recover_traction(f, t_s).ok());
  const SurfaceIntegrals own(pair.structure);
  std::array<double, 3> mean{};
  own.mean(t_s, 3, mean);
  double magnitude = 0;
  for (std::size_t i = 0; i < f.size(); i += 3) magnitude += std::hypot(f[i], f[i + 1], f[i + 2]);
  const Eigen::Vector3d integral(own.area() * mean[0], own.area() * mean[1], own.area() * mean[2]);
  return (integral - sum_nodal(pair.structure.points, f).force).norm() / magnitude;
}

void verify_pair(const std::string& name, Interface& pair, double displacement, double traction,
                 const Field& field) {
  verify(name, "displacement_error", displacement_error(pair, field), 0, displacement);
  const Load back = load(pair, field);
  verify(name, "traction_error", back.error, 0, traction);
  verify(name, "force_defect", back.force_defect, 0, 1e-12);
  // The facets of the two surfaces do not coincide: levers differ by their distance, h^2/8.
  verify(name, "moment_defect", back.moment_defect, 0, traction);
  verify(name, "force_defect_of_recovered_traction", recovered_force_defect(pair, field), 0, traction);
}

TEST(Projection, BetweenTriangles) {
  double displacement[2], traction[2];
  for (int i = 0; i < 2; ++i) {
    const Level& level = levels[i];
    Interface pair = test::pair(octahedron_hemisphere(level.splits), lat_long_hemisphere(level.rings));
    const std::string name = fmt::format("coupler/projection_t3_{}", level.name);
    std::vector<double> d_f(pair.fluid.points.size());
    ASSERT_TRUE(pair.field.apply(sample(pair.structure, constant), d_f).ok());
    verify(name, "constant", largest_difference(d_f, sample(pair.fluid, constant)), 0, 1e-13);
    verify_pair(name, pair, level.displacement, level.traction, wavy);
    displacement[i] = displacement_error(pair, wavy);
    traction[i] = load(pair, wavy).error;
    verify_pair(name + "_franke", pair, level.displacement, level.traction, franke);
  }
  const double refinement = std::log(static_cast<double>(levels[1].rings) / levels[0].rings);
  const std::string name = fmt::format("coupler/projection_t3_{}_{}", levels[0].name, levels[1].name);
  verify_between(name, "displacement_order", std::log(displacement[0] / displacement[1]) / refinement, 1.9,
                 2.6);
  verify_between(name, "traction_order", std::log(traction[0] / traction[1]) / refinement, 1.9, 2.6);
}

// Least squares is nearest in the L2 norm, not in the nodes: linear triangles that follow a curved field as
// near as they can stand off it there by up to twice what they do when the source is linear as well.
TEST(Projection, BetweenNineNodeQuadrilateralsAndTriangles) {
  for (const Level& level : levels) {
    const Surface q9 = quad9_hemisphere(level.patches), t3 = lat_long_hemisphere(level.rings);
    Interface pair = test::pair(q9, t3), back = test::pair(t3, q9);
    verify_pair(fmt::format("coupler/projection_q9_t3_{}", level.name), pair, 2 * level.displacement,
                level.traction, wavy);
    verify(fmt::format("coupler/projection_t3_q9_{}", level.name), "displacement_error",
           displacement_error(back, wavy), 0, 2 * level.displacement);
  }
}

/// Plane problems: two polygons in half a circle, all integrals exact on their common refinement.
TEST(Projection, BetweenLines) {
  const auto half_circle = [](ElementKind kind, int n) {
    return chain(kind, n, [](double s) {
      return Point{std::cos(std::numbers::pi * s), std::sin(std::numbers::pi * s), 0};
    });
  };
  const Field field = [](const Point& p) {
    return Point{std::sin(4 * p[0]) * std::cos(3 * p[1]), p[1] * p[1], 0};
  };
  double displacement[2];
  for (std::size_t i = 0; i < 2; ++i) {
    const int n = i == 0 ? 48 : 96;
    const std::string name = fmt::format("coupler/projection_lines_{}", n);
    Interface pair =
        test::pair(half_circle(ElementKind::line2, n), half_circle(ElementKind::line2, n * 11 / 8));
    displacement[i] = displacement_error(pair, field);
    verify(name, "displacement_error", displacement[i], 0, i == 0 ? 3e-3 : 7.5e-4);
    const std::vector<double> t = sample(pair.fluid, field);
    std::vector<double> f(pair.structure.points.size());
    const LoadSums given = pair.load.from_traction({pair.fluid.points, {}}, t, f);
    verify(name, "force_defect",
           (sum_nodal(pair.structure.points, f).force - given.force).norm() / given.force.norm(), 0, 1e-12);
  }
  verify_between("coupler/projection_lines", "displacement_order",
                 std::log2(displacement[0] / displacement[1]), 1.9, 2.6);
}

} // namespace
} // namespace drogue::projection::test
