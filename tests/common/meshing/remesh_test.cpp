// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/remesh.hpp"

#include <cmath>
#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "common/mesh/msh.hpp"
#include "common/meshing/membrane_volume.hpp"
#include "common/meshing/merged_surface.hpp"
#include "common/meshing/quality.hpp"
#include "common/meshing/simplex_locator.hpp"
#include "tests/common/meshing/kuhn_grid.hpp"

namespace drogue::meshing {
namespace {

using Index = std::size_t;

/// A box with a square membrane of 4 x 4 cells in its middle, cut open.
TetMesh box_with_membrane() {
  TetMesh m = kuhn_grid(8, 8, 8);
  m.interior = without_corners(grid_faces(m, 2, [](const Point& x) {
    return std::abs(x.z() - 4) < 0.1 && x.x() > 2 && x.x() < 6 && x.y() > 2 && x.y() < 6;
  }));
  const auto doubled = double_nodes(m, "upper", "lower");
  EXPECT_TRUE(doubled) << doubled.error().message;
  return m;
}

/// Sheared and bulged as a moving membrane does it; the box stays.
Point moved(const Point& x) {
  const double b = 0.01 * x.x() * (8 - x.x()) * x.y() * (8 - x.y()) / 16 * x.z() * (8 - x.z());
  return {x.x(), x.y(), x.z() + 0.5 * b};
}

mesh::Mesh moved_mesh() {
  TetMesh m = box_with_membrane();
  for (Point& x : m.points) x = moved(x);
  return to_mesh(m, "fluid");
}

TEST(TetLocator, FindsThePlaceOfEveryPoint) {
  TetMesh m = kuhn_grid(3, 4, 5);
  for (Point& x : m.points) x = moved(x);
  const TetLocator locator(m.points, m.tets);
  for (Index e = 0; e < m.tets.size(); ++e) {
    const std::array<double, 4> weight{0.1, 0.2, 0.3, 0.4};
    Point x = Point::Zero();
    for (Index a = 0; a < 4; ++a) x += weight[a] * m.points[static_cast<Index>(m.tets[e][a])];
    const TetPlace place = locator.find(x);
    ASSERT_EQ(place.cell, static_cast<std::int32_t>(e));
    for (Index a = 0; a < 4; ++a) EXPECT_NEAR(place.weight[a], weight[a], 1e-12);
    EXPECT_EQ(locator.find(x, 7).cell, place.cell);
  }
  EXPECT_EQ(locator.find(Point(100, 0, 0)).cell, -1);
}

TEST(MergedSurface, PutsTheSidesTogetherAndCutsThemOpenAgain) {
  const TetMesh m = box_with_membrane();
  const auto surface = merge_sides(m);
  ASSERT_TRUE(surface) << surface.error().message;
  EXPECT_EQ(surface->shells.size(), 1u);
  ASSERT_EQ(surface->sheets.size(), 1u);
  EXPECT_EQ(2 * surface->sheets[0].size() + surface->shells[0].size(), surface->faces.size());
  // Merged by hand: inner nodes behind those of the surface.
  std::vector<Tet> tets = m.tets;
  const auto count = static_cast<std::int32_t>(surface->points.size());
  for (Tet& tet : tets)
    for (std::int32_t& node : tet) {
      const std::int32_t merged = surface->merged[static_cast<Index>(node)];
      node = merged >= 0 ? merged : count + node;
    }
  const auto done = restore_sides(*surface, tets);
  ASSERT_TRUE(done) << done.error().message;
  for (Index e = 0; e < tets.size(); ++e)
    for (Index c = 0; c < 4; ++c) {
      const std::int32_t old = m.tets[e][c];
      EXPECT_EQ(tets[e][c], surface->merged[static_cast<Index>(old)] >= 0 ? old : count + old);
    }
}

TEST(MergedSurface, RefusesABoundaryThatIsNotClosed) {
  TetMesh m = kuhn_grid(2, 2, 2);
  m.boundaries[0].triangles.pop_back();
  const auto surface = merge_sides(m);
  ASSERT_FALSE(surface);
  EXPECT_NE(surface.error().message.find("not closed"), std::string::npos) << surface.error().message;
}

TEST(Remesh, KeepsTheBoundaryToTheBit) {
  const mesh::Mesh old = moved_mesh();
  const auto made = remesh(old);
  ASSERT_TRUE(made) << made.error().message;
  const TetMesh before = from_mesh(old), after = from_mesh(*made);
  ASSERT_EQ(before.boundaries.size(), after.boundaries.size());
  std::int32_t boundary_nodes = 0;
  for (Index b = 0; b < before.boundaries.size(); ++b) {
    EXPECT_EQ(before.boundaries[b].name, after.boundaries[b].name);
    // Nodes keep their order among themselves, triangles their place in the group.
    const auto was = old.nodes_of(before.boundaries[b].name), is = made->nodes_of(before.boundaries[b].name);
    ASSERT_EQ(was.size(), is.size());
    for (Index i = 0; i < was.size(); ++i)
      EXPECT_EQ(before.points[static_cast<Index>(was[i])], after.points[static_cast<Index>(is[i])]);
    ASSERT_EQ(before.boundaries[b].triangles.size(), after.boundaries[b].triangles.size());
    for (Index t = 0; t < before.boundaries[b].triangles.size(); ++t)
      for (Index c = 0; c < 3; ++c) {
        const auto i =
            std::lower_bound(was.begin(), was.end(), before.boundaries[b].triangles[t][c]) - was.begin();
        EXPECT_EQ(after.boundaries[b].triangles[t][c], is[static_cast<Index>(i)]);
        boundary_nodes = std::max(boundary_nodes, after.boundaries[b].triangles[t][c] + 1);
      }
  }
  EXPECT_LT(boundary_nodes, made->node_count());
  // Sizes are kept: about as many nodes as before.
  EXPECT_NEAR(made->node_count(), old.node_count(), 0.35 * old.node_count());
  const auto quality = summarise_quality(after.points, after.tets);
  EXPECT_GT(quality.smallest_mean_ratio, 0.2);
  EXPECT_GT(quality.smallest_angle, 8);
}

TEST(Remesh, CarriesLinearFieldsExactly) {
  mesh::Mesh old = moved_mesh();
  mesh::NodeField linear{2, {}};
  for (Index i = 0; i < old.points.size(); i += 3) {
    linear.values.push_back(1 + 2 * old.points[i] - old.points[i + 1] + 3 * old.points[i + 2]);
    linear.values.push_back(old.points[i + 2]);
  }
  old.node_fields["linear"] = linear;
  const auto made = remesh(old);
  ASSERT_TRUE(made) << made.error().message;
  const auto& values = made->node_fields.at("linear").values;
  ASSERT_EQ(values.size(), 2 * static_cast<Index>(made->node_count()));
  for (Index i = 0; i < static_cast<Index>(made->node_count()); ++i) {
    const double* x = made->points.data() + 3 * i;
    EXPECT_NEAR(values[2 * i], 1 + 2 * x[0] - x[1] + 3 * x[2], 1e-9);
    EXPECT_NEAR(values[2 * i + 1], x[2], 1e-10);
  }
  EXPECT_EQ(made->node_fields.count(size_field_name), 1u);
}

/// Only the tets at worn nodes are replaced, on one side of the membrane or around its edge.
TEST(Remesh, LeavesAloneWhatIsNotWorn) {
  for (const Point& place : {Point(4, 4, 2), Point(4, 4, 4.6), Point(2, 4, 4), Point(0, 0, 0)}) {
    mesh::Mesh old = moved_mesh();
    mesh::NodeField worn{1, std::vector<double>(old.points.size() / 3, 0.0)};
    for (Index i = 0; i < worn.values.size(); ++i)
      worn.values[i] =
          (Point(old.points[3 * i], old.points[3 * i + 1], old.points[3 * i + 2]) - place).norm() < 1.1 ? 1
                                                                                                        : 0;
    old.node_fields[worn_field_name] = worn;
    const auto made = remesh(old);
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(made->node_fields.count(worn_field_name), 0u);
    const auto& previous = made->node_fields.at(previous_field_name).values;
    std::int32_t kept = 0;
    for (Index i = 0; i < previous.size(); ++i)
      if (const double node = previous[i]; node >= 0) {
        ++kept;
        for (Index d = 0; d < 3; ++d)
          EXPECT_EQ(made->points[3 * i + d], old.points[3 * static_cast<Index>(node) + d]);
      }
    EXPECT_GT(kept, 0.9 * old.node_count()) << place.transpose();
    EXPECT_EQ(made->nodes_of("upper").size(), old.nodes_of("upper").size());
  }
}

TEST(Remesh, MeshesAroundABody) {
  TetMesh m = kuhn_grid(6, 6, 6);
  const auto inside = [&](const Tet& tet) {
    Point c = Point::Zero();
    for (const std::int32_t node : tet) c += 0.25 * m.points[static_cast<Index>(node)];
    return (c - Point(3, 3, 3)).cwiseAbs().maxCoeff() < 1;
  };
  NamedSurface body{"body", {}};
  for_equal_keys(sorted_faces(m.tets), [&](auto first, auto last) {
    if (last - first != 2) return;
    const bool a = inside(m.tets[static_cast<Index>(first->tet)]),
               b = inside(m.tets[static_cast<Index>((first + 1)->tet)]);
    if (a == b) return;
    const auto outer = a ? first + 1 : first;
    body.triangles.push_back(face_of(m.tets[static_cast<Index>(outer->tet)], outer->face));
  });
  m.tets.erase(std::remove_if(m.tets.begin(), m.tets.end(), inside), m.tets.end());
  std::vector<std::int32_t> number(m.points.size(), -1);
  std::vector<Point> points;
  const auto renumber = [&](std::int32_t& node) {
    std::int32_t& n = number[static_cast<Index>(node)];
    if (n < 0) {
      n = static_cast<std::int32_t>(points.size());
      points.push_back(m.points[static_cast<Index>(node)]);
    }
    node = n;
  };
  m.boundaries.push_back(body);
  for (Tet& tet : m.tets)
    for (std::int32_t& node : tet) renumber(node);
  for (NamedSurface& boundary : m.boundaries)
    for (Triangle& t : boundary.triangles)
      for (std::int32_t& node : t) renumber(node);
  m.points = points;
  const auto made = remesh(to_mesh(m, "fluid"));
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(from_mesh(*made).boundaries.back().triangles.size(), body.triangles.size());
}

TEST(Remesh, RefusesWhatItCannotMesh) {
  mesh::Mesh plane;
  plane.points = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  plane.blocks = {{"fluid", mesh::ElementKind::tri3, {0, 1, 2}}};
  const auto made = remesh(plane);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().kind, ErrorKind::config);
  mesh::Mesh two = moved_mesh();
  two.blocks.push_back(two.blocks.back());
  two.blocks.back().group = "other";
  EXPECT_FALSE(remesh(two));
}

} // namespace
} // namespace drogue::meshing
