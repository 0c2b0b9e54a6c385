// SPDX-License-Identifier: GPL-3.0-or-later
// Two dimensions, sub-increments, limits and stiffer layers.
#include "mesh_mover/algebraic_extension.hpp"
#include "mesh_mover/pseudo_solid.hpp"
#include "tests/mesh_mover/box_mesh.hpp"
#include "tests/mesh_mover/mover_cases.hpp"
#include "tests/mesh_mover/plane_mesh.hpp"

namespace drogue::mesh_mover {
namespace {

const std::array<std::string, 4> sides = {"x0", "x1", "y0", "y1"};

mesh::Mesh plane_with_body() {
  const auto axis = test::graded(1, 6, 1.6);
  return test::plane_mesh(axis, axis, [](int i, int j) {
    const auto inside = [](int a) { return a >= 5 && a <= 6; };
    return inside(i) && inside(j);
  });
}

Settings moving_body(const std::string& x, const std::string& y) {
  Settings settings;
  for (const auto& side : sides) settings.boundaries.push_back(boundary(side, Condition::fixed));
  settings.boundaries.push_back(moved("body", x, y));
  return settings;
}

Settings affine(double chi) {
  Settings settings;
  for (const auto& side : {"x0", "x1", "y0", "y1", "body"})
    settings.boundaries.push_back(moved(side, "t*(0.1 + 0.05*x - 0.08*y)", "t*(0.03*x + 0.04*y - 0.2)"));
  settings.stiffening_exponent = chi;
  return settings;
}

TEST(CellsOf, KnowsTheDimension) {
  const auto plane = test::plane_mesh({0, 1, 2}, {0, 1}, [](int, int) { return false; });
  EXPECT_EQ(cells_of(plane).dimension, 2);
  EXPECT_EQ(cells_of(plane).count(), 4U);
  auto warped = plane;
  warped.points[2] += 1e-3;
  EXPECT_EQ(cells_of(warped).count(), 0U);
  const auto grid = test::uniform(0, 1, 1);
  const auto box = test::box_mesh({grid, grid, grid}, [](int, int, int) { return false; });
  EXPECT_EQ(cells_of(box).dimension, 3);
  EXPECT_EQ(cells_of(box).count(), 6U);
}

TEST(CellsOf, TurnsAPlaneSeenFromBelow) {
  auto plane = test::plane_mesh({0, 1, 2}, {0, 1}, [](int, int) { return false; });
  auto& nodes = plane.blocks.back().nodes;
  for (std::size_t k = 0; k < nodes.size(); k += 3) std::swap(nodes[k], nodes[k + 1]);
  EXPECT_TRUE(initial_shapes(plane.points, cells_of(plane)).ok());
  std::swap(nodes[0], nodes[1]); // one the other way round is a fault
  const auto refused = initial_shapes(plane.points, cells_of(plane));
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("triangle 1"), std::string::npos) << refused.error().message;
}

TEST(CellsOf, TurnsLinesToTheCells) {
  const auto plane = test::plane_mesh({0, 1}, {0, 1}, [](int, int) { return false; });
  const Cells cells = cells_of(plane);
  for (const auto& side : sides) {
    const auto* block = plane.blocks_of(side).front();
    const std::vector<std::int32_t> turned = {block->nodes[1], block->nodes[0]};
    EXPECT_EQ(with_cells_on_the_left(block->nodes, cells), block->nodes); // plane_mesh has them so
    EXPECT_EQ(with_cells_on_the_left(turned, cells), block->nodes);
  }
}

class InThePlane : public testing::TestWithParam<Increment> {};
INSTANTIATE_TEST_SUITE_P(Increments, InThePlane,
                         testing::Values(Increment::from_last_step, Increment::from_initial));

TEST_P(InThePlane, PatchTest) {
  for (const auto kind : {LinearSolverKind::automatic, LinearSolverKind::iterative}) {
    Settings settings = affine(0);
    settings.increment = GetParam();
    settings.linear_solver = kind;
    settings.tolerance = 1e-13;
    const auto mover = make(plane_with_body(), settings);
    for (int step = 1; step <= 3; ++step) {
      step_to(*mover, step);
      const double t = step;
      EXPECT_LT(
          largest_error(
              *mover,
              [t](const double* X) -> std::array<double, 3> {
                return {t * (0.1 + 0.05 * X[0] - 0.08 * X[1]), t * (0.03 * X[0] + 0.04 * X[1] - 0.2), 0};
              }),
          1e-10);
    }
  }
}

TEST_P(InThePlane, ReturnsAfterAClosedCycleFromTheInitialMesh) {
  Settings settings = moving_body("0.3*sin(pi*t/4)", "0.1*sin(pi*t/2)");
  settings.increment = GetParam();
  const auto mover = make(plane_with_body(), settings);
  for (int step = 1; step <= 8; ++step) step_to(*mover, step);
  const double error = largest_error(*mover, [](const double*) -> std::array<double, 3> { return {}; });
  if (GetParam() == Increment::from_initial)
    EXPECT_LT(error, 1e-14);
  else
    EXPECT_GT(error, 1e-6); // the accumulated distortion, which is no error
}

// A motion that inverts elements when it is done at once succeeds in parts, and says so.
TEST_P(InThePlane, SubIncrementsGoFurther) {
  Settings settings = moving_body("0.85*t", "0");
  settings.increment = GetParam();
  settings.stiffening_exponent = 2;
  const auto at_once = make(plane_with_body(), settings);
  ASSERT_TRUE(at_once->begin_step(1).ok());
  const auto refused = solve_at(*at_once, 1);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("triangle"), std::string::npos) << refused.error().message;

  settings.max_sub_increments = 16;
  const auto mover = make(plane_with_body(), settings);
  const SolveReport report = step_to(*mover, 1);
  EXPECT_GT(report.sub_increments, 1);
  EXPECT_GT(report.quality.min_volume_ratio, 0);
  for (const std::int32_t node : mover->mesh().nodes_of("body"))
    EXPECT_EQ(mover->displacement()[3 * static_cast<std::size_t>(node)], 0.85);
  // The next step starts from what was committed, and is done at once.
  EXPECT_EQ(step_to(*mover, 0.6).sub_increments, 1);
}

TEST(Plane, WarnsAndStopsAtTheLimits) {
  Settings settings = moving_body("0.2*t", "0");
  settings.warn.f_A = 0.05;
  const auto mover = make(plane_with_body(), settings);
  const SolveReport report = step_to(*mover, 1);
  EXPECT_NE(report.warning.find("f_A"), std::string::npos) << report.warning;
  EXPECT_GT(report.quality.f_A, 0.05);

  settings.stop.angle = report.quality.smallest_angle + 1;
  const auto strict = make(plane_with_body(), settings);
  ASSERT_TRUE(strict->begin_step(1).ok());
  const auto refused = solve_at(*strict, 1);
  ASSERT_FALSE(refused.ok());
  EXPECT_TRUE(refused.error().retryable);
  EXPECT_NE(refused.error().message.find("angle"), std::string::npos) << refused.error().message;
}

// The elements of a stiff layer keep their volume better than without.
TEST(Plane, StiffLayersKeepTheirElements) {
  const auto change_beside_the_body = [](int layers) {
    Settings settings = moving_body("0.2*t + 0.3*t*x", "0.3*t*x");
    settings.stiffening_exponent = 0;
    settings.stiff_layers = {layers, 1000};
    const auto mover = make(plane_with_body(), settings);
    step_to(*mover, 0.5);
    const auto body = mover->mesh().nodes_of("body");
    double largest = 0; // of elements with one node on the body, which the layer can protect
    for (std::size_t e = 0; e < mover->cells().count(); ++e) {
      const auto cell = mover->cells().cell(e);
      const auto on_body = std::count_if(cell.begin(), cell.end(), [&](std::int32_t node) {
        return std::binary_search(body.begin(), body.end(), node);
      });
      if (on_body != 1) continue;
      const double ratio =
          simplex_jacobian<2>(mover->points(), cell) / simplex_jacobian<2>(mover->mesh().points, cell);
      largest = std::max(largest, std::abs(ratio - 1));
    }
    return largest;
  };
  EXPECT_LT(change_beside_the_body(1), 0.7 * change_beside_the_body(0));
}

// Distances along the mesh, from the nearest source.
TEST(Algebraic, NearestSources) {
  const auto mesh = plane_with_body();
  const Cells cells = cells_of(mesh);
  const auto body = mesh.nodes_of("body");
  const auto nearest =
      nearest_sources(Graph(lower_pattern(cells, mesh.points.size() / 3)), mesh.points, body);
  for (std::size_t i = 0; i < nearest.node.size(); ++i) {
    double exact = 10;
    for (const std::int32_t node : body) {
      const double* X = &mesh.points[3 * static_cast<std::size_t>(node)];
      exact = std::min(exact, std::hypot(X[0] - mesh.points[3 * i], X[1] - mesh.points[3 * i + 1]));
    }
    EXPECT_GE(nearest.distance[i], exact - 1e-14);
    EXPECT_LE(nearest.distance[i], 1.05 * exact + 1e-14); // neighbours hand on one source alone
  }
}

TEST_P(InThePlane, AlgebraicPatchTest) {
  Settings settings = affine(0);
  settings.method = Method::algebraic;
  settings.increment = GetParam();
  // One boundary around all: sides alone are lines, and do not tell an affine motion.
  auto mesh = plane_with_body();
  settings.boundaries = {settings.boundaries.front(), settings.boundaries.back()};
  settings.boundaries.front().name = "rim";
  for (auto& block : mesh.blocks)
    if (std::find(sides.begin(), sides.end(), block.group) != sides.end()) block.group = "rim";
  const auto mover = make(std::move(mesh), settings);
  for (int step = 1; step <= 3; ++step) {
    step_to(*mover, step);
    const double t = step;
    EXPECT_LT(largest_error(
                  *mover,
                  [t](const double* X) -> std::array<double, 3> {
                    return {t * (0.1 + 0.05 * X[0] - 0.08 * X[1]), t * (0.03 * X[0] + 0.04 * X[1] - 0.2), 0};
                  }),
              1e-10);
  }
}

// Several bodies, each with its own motion; the top slides, one side is translated.
class BothMethods : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, BothMethods, testing::Values(Method::elastic, Method::algebraic));

TEST_P(BothMethods, SeveralBodiesAndConditions) {
  const auto axis = test::uniform(0, 1, 12);
  auto mesh =
      test::plane_mesh(axis, axis, [](int i, int j) { return (i == 3 || i == 8) && (j == 5 || j == 6); });
  mesh::ElementBlock right{"right", mesh::ElementKind::line2, {}};
  for (auto& block : mesh.blocks) {
    if (block.group != "body") continue;
    std::vector<std::int32_t> left;
    for (std::size_t k = 0; k < block.nodes.size(); k += 2) {
      auto& to = mesh.points[3 * static_cast<std::size_t>(block.nodes[k])] > 0.5 ? right.nodes : left;
      to.insert(to.end(), {block.nodes[k], block.nodes[k + 1]});
    }
    block.nodes = left;
  }
  mesh.blocks.push_back(right);
  Settings settings;
  settings.boundaries = {boundary("x0", Condition::fixed),      boundary("x1", Condition::translated),
                         boundary("y0", Condition::sliding, 1), boundary("y1", Condition::sliding, 1),
                         moved("body", "0.1*t", "0"),           moved("right", "0", "0.08*t")};
  settings.method = GetParam();
  const auto mover = make(std::move(mesh), settings);
  ASSERT_TRUE(mover->begin_step(1).ok());
  BoundaryInput input;
  input.time = 1;
  input.translation = {0.05, 0, 0};
  const auto report = mover->solve(input);
  ASSERT_TRUE(report.ok()) << report.error().message;
  const auto u = mover->displacement();
  const auto at = [&](const char* group, std::size_t c) {
    std::vector<double> values;
    for (const std::int32_t node : mover->mesh().nodes_of(group))
      values.push_back(u[3 * static_cast<std::size_t>(node) + c]);
    return values;
  };
  for (const double value : at("body", 0)) EXPECT_EQ(value, 0.1);
  for (const double value : at("right", 1)) EXPECT_EQ(value, 0.08);
  for (const double value : at("x1", 0)) EXPECT_EQ(value, 0.05);
  for (const double value : at("y1", 1)) EXPECT_EQ(value, 0);
  const auto top = at("y1", 0); // between the fixed and the translated end
  EXPECT_EQ(*std::min_element(top.begin(), top.end()), 0);
  EXPECT_GT(std::count_if(top.begin(), top.end(), [](double x) { return x > 0.01 && x < 0.045; }), 2);
}

} // namespace
} // namespace drogue::mesh_mover
