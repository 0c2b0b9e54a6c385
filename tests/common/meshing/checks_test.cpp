// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/checks.hpp"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "common/meshing/quality.hpp"
#include "tests/common/meshing/kuhn_grid.hpp"

namespace drogue::meshing {
namespace {

/// The message of a failed check, empty when it passed.
std::string complaint(const Result<void>& checked) {
  return checked ? "" : checked.error().message;
}

void expect_refused(const TetMesh& m, const char* because) {
  EXPECT_NE(complaint(check_volume(m)).find(because), std::string::npos) << complaint(check_volume(m));
}

TEST(CheckVolume, AcceptsAGrid) {
  EXPECT_EQ(complaint(check_volume(kuhn_grid(3, 2, 2))), "");
}

TEST(CheckVolume, RefusesAHole) {
  TetMesh m = kuhn_grid(3, 3, 3);
  m.tets.erase(m.tets.begin() + 6 * 13);
  expect_refused(m, "not conforming");
}

TEST(CheckVolume, RefusesAnInvertedTet) {
  TetMesh m = kuhn_grid(2, 2, 2);
  std::swap(m.tets[5][0], m.tets[5][1]);
  expect_refused(m, "1 of 48 tetrahedra have no positive volume");
}

TEST(CheckVolume, RefusesAFlatTetAndNan) {
  TetMesh m = kuhn_grid(2, 2, 2);
  m.points[13].setConstant(std::nan(""));
  expect_refused(m, "no positive volume");
}

TEST(CheckVolume, RefusesATetTwice) {
  TetMesh m = kuhn_grid(2, 2, 2);
  m.tets.push_back(m.tets[20]);
  expect_refused(m, "more than two tetrahedra");
}

TEST(CheckVolume, RefusesAnOrphanNode) {
  TetMesh m = kuhn_grid(2, 2, 2);
  m.points.emplace_back(0.5, 0.5, 0.5);
  expect_refused(m, "1 nodes belong to no tetrahedron");
}

TEST(CheckVolume, RefusesAMissingAndAReversedBoundaryTriangle) {
  TetMesh missing = kuhn_grid(2, 2, 2);
  missing.boundaries[0].triangles.pop_back();
  expect_refused(missing, "1 faces of a single tetrahedron are in no named boundary");
  TetMesh reversed = kuhn_grid(2, 2, 2);
  std::swap(reversed.boundaries[0].triangles[0][0], reversed.boundaries[0].triangles[0][1]);
  expect_refused(reversed, "not conforming");
}

TEST(CheckVolume, RefusesTetsThatMeetInANodeOnly) {
  TetMesh m;
  m.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  m.tets = {{0, 1, 2, 3}, {0, 5, 4, 6}};
  orient(m);
  m.boundaries = {{"all", {}}};
  for (const Tet& tet : m.tets)
    for (int f = 0; f < 4; ++f) m.boundaries[0].triangles.push_back(face_of(tet, f));
  expect_refused(m, "around 1 nodes are not connected");
}

TEST(CheckTwoSided, RefusesAnOpenOrReversedSide) {
  const std::vector<Triangle> upper{{0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const std::vector<Triangle> lower{{1, 0, 4}, {2, 1, 4}, {0, 2, 4}};
  EXPECT_EQ(complaint(check_two_sided(upper, lower)), "");
  EXPECT_EQ(euler_characteristic(upper), 1);
  EXPECT_NE(complaint(check_two_sided(upper, {lower.begin(), lower.end() - 1})), "");
  std::vector<Triangle> reversed = lower;
  for (Triangle& t : reversed) std::swap(t[0], t[1]);
  EXPECT_NE(complaint(check_two_sided(upper, reversed)), "");
}

TEST(CheckTwoSided, RefusesTheWrongTopology) {
  // One node where a membrane ought to have two: the sides close, but pinched.
  const std::vector<Triangle> upper{{0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const std::vector<Triangle> lower{{1, 0, 3}, {2, 1, 3}, {0, 2, 3}};
  EXPECT_NE(complaint(check_two_sided(upper, lower)), "");
}

TEST(Quality, RegularTet) {
  const std::vector<Point> x{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  const Tet tet = {0, 2, 1, 3};
  const double sign = volume(x, tet) > 0 ? 1 : -1;
  EXPECT_NEAR(std::abs(volume(x, tet)), 8.0 / 3, 1e-14);
  EXPECT_NEAR(mean_ratio(x, tet), sign, 1e-14);
  EXPECT_NEAR(mean_ratio(x, {2, 0, 1, 3}), -sign, 1e-14);
  const Tet positive = sign > 0 ? tet : Tet{2, 0, 1, 3};
  EXPECT_NEAR(smallest_dihedral_angle(x, positive), std::acos(1.0 / 3) * 180 / M_PI, 1e-10);
}

TEST(Quality, KuhnTetsHaveFortyFiveDegrees) {
  const TetMesh m = kuhn_grid(2, 2, 2);
  const QualitySummary q = summarise_quality(m.points, m.tets);
  EXPECT_NEAR(q.smallest_angle, 45, 1e-10);
  EXPECT_NEAR(q.smallest_volume, 1.0 / 6, 1e-15);
  EXPECT_NEAR(q.total_volume, 8, 1e-13);
  EXPECT_EQ(q.below_10_degrees, 0);
}

} // namespace
} // namespace drogue::meshing
