// SPDX-License-Identifier: GPL-3.0-or-later
// A flow that starts from the state of another mesh.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fluid_solver/flow_state.hpp"
#include "tests/fluid_solver/box.hpp"

namespace drogue::fluid {
namespace {

using namespace test;

FluidMesh usable(mesh::Mesh file) {
  auto made = FluidMesh::create(std::move(file));
  EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
  return std::move(*made);
}

/// Linear in all components.
FlowState linear_flow(const FluidMesh& mesh) {
  FlowState s;
  s.time = 0.7;
  s.step = 5;
  s.x = mesh.points;
  for (std::size_t i = 0; i < mesh.points.size(); i += 3) {
    const double* x = mesh.points.data() + i;
    s.u.insert(s.u.end(), {1 + x[0] - x[1], 2 * x[2] + x[1], x[0]});
    s.p.push_back(3 - x[0] + 2 * x[1] - x[2]);
  }
  s.wall_velocity = s.u;
  s.u_before = s.u;
  s.step_before = 0.1;
  return s;
}

void expect_same(const FlowState& a, const FlowState& b, double tolerance) {
  ASSERT_EQ(a.u.size(), b.u.size());
  ASSERT_EQ(a.p.size(), b.p.size());
  for (std::size_t i = 0; i < a.u.size(); ++i) EXPECT_NEAR(a.u[i], b.u[i], tolerance);
  for (std::size_t i = 0; i < a.p.size(); ++i) EXPECT_NEAR(a.p[i], b.p[i], tolerance);
}

TEST(OtherMesh, LinearFieldsComeOverExactly) {
  const FluidMesh from[] = {usable(box_mesh({4, 3, 6}, {1, 1, 2})), usable(rectangle_mesh({4, 7}, {1, 2}))};
  const FluidMesh to[] = {usable(box_mesh({5, 7, 4}, {1, 1, 2}, true)),
                          usable(rectangle_mesh({9, 5}, {1, 2}, true))};
  for (int k = 0; k < 2; ++k) {
    const auto here = interpolated(linear_flow(from[k]), from[k], to[k]);
    ASSERT_TRUE(here.ok()) << here.error().message;
    expect_same(*here, linear_flow(to[k]), 1e-12);
    EXPECT_EQ(here->time, 0.7);
    EXPECT_EQ(here->step, 5U);
    EXPECT_EQ(here->x, to[k].points);
    EXPECT_TRUE(here->u_before.empty());
    EXPECT_EQ(*std::max_element(here->wall_velocity.begin(), here->wall_velocity.end()), 0);
  }
}

TEST(OtherMesh, OnTheMeshItselfNothingChanges) {
  const FluidMesh mesh = usable(box_mesh({4, 3, 6}, {1, 1, 2}));
  FlowState s = linear_flow(mesh);
  for (double& p : s.p) p = std::sin(7 * p);
  const auto here = interpolated(s, mesh, mesh);
  ASSERT_TRUE(here.ok());
  expect_same(*here, s, 1e-13);
}

/// Two boxes whose nodes between them are at the same places and not joined: a canopy has such sides.
mesh::Mesh cut_box(std::array<int, 2> n) {
  mesh::Mesh m = box_mesh({n[0], n[0], n[1]}, {1, 1, 1});
  const mesh::Mesh above = box_mesh({n[0], n[0], n[1]}, {1, 1, 1});
  const std::int32_t shift = m.node_count();
  for (std::size_t i = 0; i < above.points.size(); i += 3)
    m.points.insert(m.points.end(), {above.points[i], above.points[i + 1], above.points[i + 2] + 1});
  for (std::size_t b = 0; b < above.blocks.size(); ++b)
    for (const std::int32_t node : above.blocks[b].nodes) m.blocks[b].nodes.push_back(node + shift);
  return m;
}

TEST(OtherMesh, EachSideOfASurfaceWithoutThicknessKeepsItsOwn) {
  const FluidMesh from = usable(cut_box({3, 4})), to = usable(cut_box({4, 3}));
  FlowState s = linear_flow(from);
  const auto side_of = [](const FluidMesh& mesh, std::size_t i) {
    return mesh.to_file[i] < mesh.node_count() / 2 ? -1.0 : 1.0;
  };
  for (std::size_t i = 0; i < s.p.size(); ++i) s.p[i] = side_of(from, i);
  const auto here = interpolated(s, from, to);
  ASSERT_TRUE(here.ok());
  for (std::size_t i = 0; i < here->p.size(); ++i) EXPECT_NEAR(here->p[i], side_of(to, i), 1e-12) << i;
}

/// The finer polygon round a circle lies outside the coarser one, and comes over all the same.
TEST(OtherMesh, ACurvedBoundaryMayBeDividedOtherwise) {
  const auto bent = [](int around) {
    mesh::Mesh m = rectangle_mesh({around, 4}, {1, 1});
    for (std::size_t i = 0; i < m.points.size(); i += 3) {
      const double angle = 0.5 * std::numbers::pi * m.points[i], r = 2 - m.points[i + 1];
      m.points[i] = r * std::sin(angle);
      m.points[i + 1] = r * std::cos(angle);
    }
    return usable(std::move(m));
  };
  const FluidMesh from = bent(6), to = bent(15);
  const auto here = interpolated(linear_flow(from), from, to);
  ASSERT_TRUE(here.ok()) << here.error().message;
  expect_same(*here, linear_flow(to), 0.06); // r (1 - cos(7.5 degrees)) = 0.017, times the gradient
}

TEST(OtherMesh, AnotherDomainIsRefusedWithTheNode) {
  const FluidMesh from = usable(box_mesh({3, 3, 3}, {1, 1, 1})), to = usable(box_mesh({3, 3, 5}, {1, 1, 2}));
  const auto refused = interpolated(linear_flow(from), from, to);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind, ErrorKind::config);
  EXPECT_NE(refused.error().message.find("outside the state's mesh"), std::string::npos);
  const FluidMesh plane = usable(rectangle_mesh({3, 3}, {1, 1}));
  EXPECT_NE(interpolated(linear_flow(from), from, plane).error().message.find("dimensions"),
            std::string::npos);
}

} // namespace
} // namespace drogue::fluid
