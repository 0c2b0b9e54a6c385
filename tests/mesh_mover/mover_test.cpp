// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mesh_mover/box_mesh.hpp"
#include "tests/mesh_mover/mover_cases.hpp"

namespace drogue::mesh_mover {
namespace {

const std::array<std::string, 6> sides = {"x0", "x1", "y0", "y1", "z0", "z1"};

mesh::Mesh plain_box() {
  return test::box_mesh({test::uniform(0, 1, 5), test::uniform(0, 1.5, 4), test::uniform(0, 1, 6)},
                        [](int, int, int) { return false; });
}

/// A cube of half width 1 with a small cubic hole in its middle, fine around it.
mesh::Mesh graded_box_with_body() {
  const auto axis = test::graded(1, 5, 1.8);
  return test::box_mesh({axis, axis, axis}, [](int i, int j, int k) {
    const auto inside = [](int a) { return a == 4 || a == 5; };
    return inside(i) && inside(j) && inside(k);
  });
}

Settings all_sides(const std::string& x, const std::string& y, const std::string& z) {
  Settings settings;
  for (const auto& side : sides) settings.boundaries.push_back(moved(side, x, y, z));
  settings.linear_solver = LinearSolverKind::iterative;
  settings.tolerance = 1e-13;
  settings.max_iterations = 5000;
  return settings;
}

Settings moving_body(const std::string& x) {
  Settings settings;
  for (const auto& side : sides) settings.boundaries.push_back(boundary(side, Condition::fixed));
  settings.boundaries.push_back(moved("body", x, "0", "0"));
  settings.linear_solver = LinearSolverKind::iterative;
  settings.tolerance = 1e-12;
  settings.max_iterations = 5000;
  return settings;
}

class BothIncrements : public testing::TestWithParam<Increment> {};
INSTANTIATE_TEST_SUITE_P(Increments, BothIncrements,
                         testing::Values(Increment::from_last_step, Increment::from_initial));

// Plain elasticity reproduces every affine motion of the boundary inside, over several steps.
TEST_P(BothIncrements, PatchTest) {
  Settings settings = all_sides("t*(0.1 + 0.05*x - 0.08*y + 0.02*z)", "t*(0.03*x + 0.04*y - 0.2)",
                                "t*(0.01 + 0.06*x + 0.02*y - 0.05*z)");
  settings.stiffening_exponent = 0;
  settings.increment = GetParam();
  const auto mover = make(plain_box(), settings);
  for (int step = 1; step <= 3; ++step) {
    step_to(*mover, step);
    const double t = step;
    EXPECT_LT(largest_error(*mover,
                            [t](const double* X) -> std::array<double, 3> {
                              return {t * (0.1 + 0.05 * X[0] - 0.08 * X[1] + 0.02 * X[2]),
                                      t * (0.03 * X[0] + 0.04 * X[1] - 0.2),
                                      t * (0.01 + 0.06 * X[0] + 0.02 * X[1] - 0.05 * X[2])};
                            }),
              1e-10);
  }
}

// With stiffening only motions without strain are reproduced: here an infinitesimal rotation, in one step.
TEST_P(BothIncrements, StiffenedSolidReproducesInfinitesimalRotation) {
  Settings settings = moving_body("0");
  settings.boundaries.clear();
  for (const auto& side : sides) settings.boundaries.push_back(moved(side, "-0.1*t*y", "0.1*t*x", "0"));
  settings.boundaries.push_back(moved("body", "-0.1*t*y", "0.1*t*x", "0"));
  settings.stiffening_exponent = 1.5;
  settings.increment = GetParam();
  const auto mover = make(graded_box_with_body(), settings);
  step_to(*mover, 1);
  EXPECT_LT(largest_error(*mover,
                          [](const double* X) -> std::array<double, 3> {
                            return {-0.1 * X[1], 0.1 * X[0], 0};
                          }),
            1e-10);
}

// A loose tolerance does not hurt a rigid translation: it needs no iteration.
TEST_P(BothIncrements, RigidTranslationIsExact) {
  Settings settings = moving_body("0");
  settings.boundaries.clear();
  for (const auto& side : sides) settings.boundaries.push_back(boundary(side, Condition::translated));
  settings.boundaries.push_back(moved("body", "0.3*t", "-0.2*t", "0.7*t"));
  settings.tolerance = 1e-2;
  settings.increment = GetParam();
  const auto mover = make(graded_box_with_body(), settings);
  for (int step = 1; step <= 3; ++step) {
    const double t = step * step;
    ASSERT_TRUE(mover->begin_step(1).ok());
    BoundaryInput input;
    input.time = t;
    input.translation = {0.3 * t, -0.2 * t, 0.7 * t};
    const auto report = mover->solve(input);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(report->iterations, 0);
    mover->commit();
    EXPECT_LT(largest_error(*mover,
                            [t](const double*) -> std::array<double, 3> {
                              return {0.3 * t, -0.2 * t, 0.7 * t};
                            }),
              1e-12 * t);
  }
}

double error_after_cycle(Increment increment) {
  Settings settings = moving_body("0.25*sin(pi*t/4)");
  settings.increment = increment;
  const auto mover = make(graded_box_with_body(), settings);
  for (int step = 1; step <= 8; ++step) step_to(*mover, step);
  return largest_error(*mover, [](const double*) -> std::array<double, 3> { return {0, 0, 0}; });
}

TEST(MeshMover, FromInitialReturnsAfterAClosedCycle) {
  EXPECT_LT(error_after_cycle(Increment::from_initial), 1e-10);
  EXPECT_GT(error_after_cycle(Increment::from_last_step),
            1e-6); // the accumulated distortion, which is no error
}

double min_volume_ratio_with(double stiffening_exponent) {
  Settings settings = moving_body("0.05*t");
  settings.stiffening_exponent = stiffening_exponent;
  const auto mover = make(graded_box_with_body(), settings);
  double smallest = 1;
  for (int step = 1; step <= 3; ++step)
    smallest = std::min(smallest, step_to(*mover, step).quality.min_volume_ratio);
  return smallest;
}

TEST(MeshMover, StiffeningProtectsSmallElements) {
  const double without = min_volume_ratio_with(0);
  const double with = min_volume_ratio_with(1);
  EXPECT_GT(with, without + 0.05);
  EXPECT_LT(with, 1);
}

TEST(MeshMover, RefusesAnInvertedElementAndRollsBack) {
  Settings settings = moving_body("t");
  settings.tolerance = 1e-4;
  const auto mover = make(graded_box_with_body(), settings);
  step_to(*mover, 0.1);
  const std::vector<double> before(mover->displacement().begin(), mover->displacement().end());
  ASSERT_TRUE(mover->begin_step(1).ok());
  const auto refused = solve_at(*mover, 1.2); // the body would leave the box
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind, ErrorKind::numerical);
  EXPECT_TRUE(refused.error().retryable);
  EXPECT_NE(refused.error().message.find("is inverted"), std::string::npos) << refused.error().message;
  EXPECT_NE(refused.error().message.find("tetrahedron"), std::string::npos);
  mover->rollback();
  EXPECT_TRUE(std::equal(before.begin(), before.end(), mover->displacement().begin()));
  EXPECT_GT(step_to(*mover, 0.15).quality.min_volume_ratio, 0.01);
}

TEST(MeshMover, RefusesACollapsingElement) {
  Settings settings = moving_body("t");
  settings.stop.min_volume_ratio = 0.9;
  const auto mover = make(graded_box_with_body(), settings);
  ASSERT_TRUE(mover->begin_step(1).ok());
  const auto refused = solve_at(*mover, 0.2);
  ASSERT_FALSE(refused.ok());
  EXPECT_TRUE(refused.error().retryable);
  EXPECT_NE(refused.error().message.find("collapses"), std::string::npos) << refused.error().message;
}

TEST(MeshMover, ReportsAnIterationThatDoesNotConverge) {
  Settings settings = moving_body("0.05*t");
  settings.max_iterations = 2;
  const auto mover = make(graded_box_with_body(), settings);
  ASSERT_TRUE(mover->begin_step(1).ok());
  const auto refused = solve_at(*mover, 1);
  ASSERT_FALSE(refused.ok());
  EXPECT_TRUE(refused.error().retryable);
  EXPECT_NE(refused.error().message.find("did not converge"), std::string::npos) << refused.error().message;
}

// Two sliding planes combine on their edge; the stronger boundary wins on the others.
TEST(MeshMover, SlidingPlanesAndPrecedence) {
  Settings settings;
  settings.boundaries = {boundary("x0", Condition::sliding, 0), boundary("x1", Condition::sliding, 0),
                         boundary("y0", Condition::sliding, 1), boundary("y1", Condition::sliding, 1),
                         boundary("z0", Condition::fixed),      moved("z1", "0", "0", "0.2*t")};
  settings.tolerance = 1e-13;
  settings.stiffening_exponent = 0;
  const auto mover = make(plain_box(), settings);
  step_to(*mover, 1);
  // Uniaxial strain: exact, as the sides slide.
  EXPECT_LT(largest_error(*mover,
                          [](const double* X) -> std::array<double, 3> {
                            return {0, 0, 0.2 * X[2]};
                          }),
            1e-10);
}

TEST(MeshMover, RefusesAFreeDirection) {
  Settings settings;
  for (const auto& side : sides) settings.boundaries.push_back(boundary(side, Condition::sliding, 0));
  const auto mover = MeshMover::create(plain_box(), settings);
  ASSERT_FALSE(mover.ok());
  EXPECT_EQ(mover.error().kind, ErrorKind::config);
  EXPECT_NE(mover.error().message.find("direction y"), std::string::npos) << mover.error().message;
}

TEST(MeshMover, RefusesAnInitialMeshWithAnInvertedElement) {
  auto mesh = plain_box();
  for (auto& block : mesh.blocks)
    if (block.kind == mesh::ElementKind::tet4) std::swap(block.nodes[4 * 7], block.nodes[4 * 7 + 1]);
  const auto mover = MeshMover::create(std::move(mesh), all_sides("0", "0", "0"));
  ASSERT_FALSE(mover.ok());
  EXPECT_NE(mover.error().message.find("tetrahedron 7"), std::string::npos) << mover.error().message;
}

} // namespace
} // namespace drogue::mesh_mover
