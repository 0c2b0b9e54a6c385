// SPDX-License-Identifier: GPL-3.0-or-later
//
// Fluid meshes around the T-10: the full mesh at the size of [stein2001], and twelve shapes of the canopy on
// a smaller one. Every mesh that mesh_membrane_volume() returns conforms and has no element without volume;
// here it is checked again, with the quality: dihedral angles of 8 degrees at least.
#include <gtest/gtest.h>

#include "common/meshing/checks.hpp"
#include "common/meshing/quality.hpp"
#include "tests/support/t10_shapes.hpp"
#include "tests/support/verify.hpp"

namespace drogue::parachute {
namespace {

using test::verify;
using test::verify_between;

void check(const std::string& name, const FluidMeshResult& made) {
  const meshing::TetMesh m = meshing::from_mesh(made.mesh);
  const auto valid = meshing::check_volume(m);
  EXPECT_TRUE(valid.ok()) << valid.error().message;
  const auto closed = meshing::check_two_sided(m.boundaries[3].triangles, m.boundaries[4].triangles);
  EXPECT_TRUE(closed.ok()) << closed.error().message;
  verify(name, "failed_checks", !valid + !closed, 0, 0);
  const auto quality = meshing::summarise_quality(m.points, m.tets);
  verify_between(name, "smallest_dihedral_angle", quality.smallest_angle, 8, 71); // 70.5 at most
}

TEST(T10FluidMesh, PapersSize) {
  const auto surface = test::t10_surface(test::t10_fluid_paper);
  ASSERT_TRUE(surface.ok()) << surface.error().message;
  const auto made = test::t10_fluid_mesh(test::t10_fluid_paper, *surface);
  ASSERT_TRUE(made.ok()) << made.error().message;
  check("t10/fluid_mesh", *made);
  verify("t10/fluid_mesh", "nodes", made->mesh.node_count(), 133097, 0.02 * 133097);
  verify("t10/fluid_mesh", "doubled_nodes", made->volume.doubling.doubled_nodes, 8640, 0);
  verify("t10/fluid_mesh", "single_nodes", made->volume.doubling.single_nodes, 210, 0);
}

class T10FluidMeshAround : public testing::TestWithParam<test::T10Shape> {};

TEST_P(T10FluidMeshAround, TheShape) {
  const auto surface = test::t10_surface(test::t10_fluid_middle, GetParam());
  ASSERT_TRUE(surface.ok()) << surface.error().message;
  const auto made = test::t10_fluid_mesh(test::t10_fluid_middle, *surface);
  ASSERT_TRUE(made.ok()) << (made ? "" : made.error().message);
  check("t10/fluid_mesh_" + GetParam().name, *made);
}

INSTANTIATE_TEST_SUITE_P(Shapes, T10FluidMeshAround, testing::ValuesIn(test::t10_shapes()),
                         [](const auto& shape) { return shape.param.name; });

} // namespace
} // namespace drogue::parachute
