// SPDX-License-Identifier: GPL-3.0-or-later
// Plane meshes made anew inside their boundary lines.
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "common/meshing/quality.hpp"
#include "common/meshing/remesh.hpp"
#include "tests/mesh_mover/plane_mesh.hpp"

namespace drogue::meshing {
namespace {

using Index = std::size_t;

/// A square with a square hole, in which the hole was carried to the right and the mesh with it.
mesh::Mesh distorted() {
  std::vector<double> cuts;
  for (int i = 0; i <= 20; ++i) cuts.push_back(0.1 * i - 1);
  mesh::Mesh m = test::plane_mesh(cuts, cuts, [](int i, int j) {
    const auto inside = [](int a) { return a >= 8 && a <= 11; };
    return inside(i) && inside(j);
  });
  for (Index i = 0; i < m.points.size(); i += 3) {
    const double r = std::max(std::abs(m.points[i]), std::abs(m.points[i + 1]));
    m.points[i] += 0.55 * std::clamp((1 - r) / 0.8, 0.0, 1.0);
  }
  return m;
}

std::vector<Point> points_of(const mesh::Mesh& m) {
  std::vector<Point> points;
  for (Index i = 0; i < m.points.size(); i += 3)
    points.emplace_back(m.points[i], m.points[i + 1], m.points[i + 2]);
  return points;
}

struct Figures {
  double area = 0, worst = 1;
};
Figures figures_of(const mesh::Mesh& m) {
  Figures f;
  const std::vector<Point> x = points_of(m);
  for (const mesh::ElementBlock* block : m.blocks_of("fluid"))
    for (std::int32_t e = 0; e < block->count(); ++e) {
      const Triangle t{block->element(e)[0], block->element(e)[1], block->element(e)[2]};
      const Point a = x[static_cast<Index>(t[1])] - x[static_cast<Index>(t[0])],
                  b = x[static_cast<Index>(t[2])] - x[static_cast<Index>(t[0])];
      f.area += 0.5 * (a.x() * b.y() - a.y() * b.x());
      f.worst = std::min(f.worst, mean_ratio(x, t));
    }
  return f;
}

/// Positions of the lines' ends, group by group.
std::vector<double> lines_of(const mesh::Mesh& m) {
  std::vector<double> ends;
  for (const mesh::ElementBlock& block : m.blocks)
    if (block.kind == mesh::ElementKind::line2)
      for (const std::int32_t node : block.nodes)
        for (Index d = 0; d < 3; ++d) ends.push_back(m.points[3 * static_cast<Index>(node) + d]);
  return ends;
}

TEST(Quality, OfTriangles) {
  const std::vector<Point> x = {{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}, {0, 1, 0}};
  EXPECT_NEAR(mean_ratio(x, Triangle{0, 1, 2}), 1, 1e-15);
  EXPECT_NEAR(mean_ratio(x, Triangle{0, 2, 1}), -1, 1e-15);
  EXPECT_NEAR(mean_ratio(x, Triangle{0, 1, 3}), std::sqrt(3.0) / 2, 1e-15);
  EXPECT_NEAR(smallest_angle(x, Triangle{0, 1, 2}), 60, 1e-12);
  EXPECT_NEAR(smallest_angle(x, Triangle{0, 1, 3}), 45, 1e-12);
}

TEST(RemeshPlane, KeepsTheBoundaryToTheBitAndIsBetter) {
  const mesh::Mesh old = distorted();
  const auto made = remesh(old);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(lines_of(old), lines_of(*made));
  EXPECT_EQ(old.group_names(), made->group_names());
  const Figures before = figures_of(old), after = figures_of(*made);
  EXPECT_NEAR(after.area, before.area, 1e-12);
  EXPECT_LT(before.worst, 0.5);
  EXPECT_GT(after.worst, 0.6);
  EXPECT_NEAR(made->node_count(), old.node_count(), 0.25 * old.node_count());
  for (Index i = 2; i < made->points.size(); i += 3) EXPECT_EQ(made->points[i], 0.5);
}

TEST(RemeshPlane, ReplacesWornTrianglesOnly) {
  mesh::Mesh old = distorted();
  mesh::NodeField worn{1, {}}, linear{2, {}};
  for (Index i = 0; i < old.points.size(); i += 3) {
    const double x = old.points[i], y = old.points[i + 1];
    worn.values.push_back(x > 0.6 && std::abs(y) < 0.5 ? 1 : 0);
    linear.values.insert(linear.values.end(), {2 * x - y, 3 + y});
  }
  old.node_fields[worn_field_name] = worn;
  old.node_fields["linear"] = linear;
  const auto made = remesh(old);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(lines_of(old), lines_of(*made));
  EXPECT_NEAR(figures_of(*made).area, figures_of(old).area, 1e-12);
  const std::vector<double>&previous = made->node_fields.at(previous_field_name).values,
        &carried = made->node_fields.at("linear").values;
  double last = -1;
  int fresh = 0;
  for (Index i = 0; i < previous.size(); ++i) {
    const double x = made->points[3 * i], y = made->points[3 * i + 1];
    EXPECT_NEAR(carried[2 * i], 2 * x - y, 1e-12);
    EXPECT_NEAR(carried[2 * i + 1], 3 + y, 1e-12);
    if (std::isnan(previous[i])) {
      ++fresh;
      EXPECT_GT(x, 0.4);
      continue;
    }
    EXPECT_EQ(fresh, 0); // the new ones come last
    EXPECT_GT(previous[i], last);
    last = previous[i];
    for (Index d = 0; d < 3; ++d)
      EXPECT_EQ(made->points[3 * i + d], old.points[3 * static_cast<Index>(last) + d]);
  }
  EXPECT_GT(fresh, 5);
  EXPECT_GT(made->node_count() - fresh, old.node_count() / 2);
}

TEST(RemeshPlane, RefusesWhatItCannotMesh) {
  const auto refused = [](const mesh::Mesh& m) {
    const auto made = remesh(m);
    EXPECT_FALSE(made);
    return made || made.error().kind != ErrorKind::config ? std::string() : made.error().message;
  };
  mesh::Mesh no_lines = distorted();
  no_lines.blocks.erase(no_lines.blocks.begin());
  EXPECT_NE(refused(no_lines).find("outer edges"), std::string::npos);
  mesh::Mesh bent = distorted();
  bent.points[2] += 1e-3;
  EXPECT_NE(refused(bent).find("another plane"), std::string::npos);
  // A cut: two rows of nodes at the same places.
  const std::vector<double> cuts = {0, 1, 2, 3, 4};
  mesh::Mesh cut = test::plane_mesh(cuts, cuts, [](int i, int j) { return j == 2 && i > 0 && i < 3; });
  for (Index i = 0; i < cut.points.size(); i += 3)
    if (cut.points[i + 1] == 3 && cut.points[i] > 1 && cut.points[i] < 3) cut.points[i + 1] = 2;
  EXPECT_NE(refused(cut).find("touches itself"), std::string::npos);
}

} // namespace
} // namespace drogue::meshing
