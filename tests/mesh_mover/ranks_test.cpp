// SPDX-License-Identifier: GPL-3.0-or-later
//
// Several ranks move a mesh as one does. Runs under mpiexec on 1, 2 and 3 ranks: the first makes the movers
// and compares with extensions of its own that share nothing, the others do their share.
#include <cmath>

#include "common/la_direct/direct_solver.hpp"
#include "common/la_krylov/session.hpp"
#include "mesh_mover/shared_extension.hpp"
#include "tests/mesh_mover/box_mesh.hpp"
#include "tests/mesh_mover/mover_cases.hpp"

namespace drogue::mesh_mover {
namespace {

/// A graded box with a moving floor, held on one side and sliding on others.
mesh::Mesh box() {
  const auto cuts = test::graded(1, 8, 1.15);
  return test::box_mesh({cuts, cuts, cuts}, [](int, int, int) { return false; });
}

Settings settings() {
  Settings settings;
  settings.boundaries = {moved("z0", "0.015*t*(x + 1)*y", "0", "0.015*t*(x + 1)*(2 - y)"),
                         boundary("x0", Condition::fixed), boundary("y0", Condition::sliding, 1),
                         boundary("z1", Condition::sliding, 2)};
  settings.tolerance = 1e-11;
  settings.linear_solver = LinearSolverKind::iterative;
  return settings;
}

/// Two steps, the second from the moved mesh.
std::vector<double> displacement_after_two_steps(const Settings& settings) {
  const auto mover = make(box(), settings);
  step_to(*mover, 0.5);
  step_to(*mover, 1);
  return {mover->displacement().begin(), mover->displacement().end()};
}

/// The same on this rank alone.
std::vector<double> alone(const Settings& settings) {
  const mesh::Mesh mesh = box();
  const Cells cells = cells_of(mesh);
  const auto motion = BoundaryMotion::create(mesh, 3, settings.boundaries);
  const auto shapes = initial_shapes(mesh.points, cells);
  auto extension = make_extension(extension_input(settings, cells, *motion, shapes->jacobians), false);
  std::vector<double> points = mesh.points, total(points.size(), 0.0);
  for (const double time : {0.5, 1.0}) {
    BoundaryInput input;
    input.time = time;
    std::vector<double> target = total;
    motion->evaluate(input, mesh.points, target);
    std::vector<double> w(total.size());
    for (std::size_t i = 0; i < w.size(); ++i) w[i] = target[i] - total[i]; // zero where nothing is given
    EXPECT_TRUE(extension->prepare(points).ok());
    const auto outcome = extension->extend(w, std::vector<double>(w));
    EXPECT_TRUE(outcome.ok() && outcome->converged);
    for (std::size_t i = 0; i < w.size(); ++i) {
      total[i] += w[i];
      points[i] = mesh.points[i] + total[i];
    }
  }
  return total;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

TEST(Ranks, ElasticDisplacementIsThatOfOneRank) {
  const auto shared = displacement_after_two_steps(settings());
  EXPECT_GT(largest_difference(shared, std::vector<double>(shared.size(), 0.0)), 0.05);
  EXPECT_LT(largest_difference(shared, alone(settings())), 1e-9);
}

TEST(Ranks, StiffLayersAreThoseOfOneRank) {
  Settings stiff = settings();
  stiff.stiff_layers = {.layers = 2, .factor = 30};
  EXPECT_LT(largest_difference(displacement_after_two_steps(stiff), alone(stiff)), 1e-9);
}

TEST(Ranks, AlgebraicDisplacementIsThatOfOneRank) {
  Settings algebraic = settings();
  algebraic.method = Method::algebraic;
  algebraic.boundaries = {moved("z0", "0.05*t", "0.02*t", "0.05*t*(1 + x*y)"),
                          boundary("z1", Condition::fixed)};
  const auto shared = displacement_after_two_steps(algebraic);
  EXPECT_GT(largest_difference(shared, std::vector<double>(shared.size(), 0.0)), 0.01);
  EXPECT_LT(largest_difference(shared, alone(algebraic)), 1e-14);
}

TEST(Ranks, DirectFactorsAreMadeByOneRank) {
  Settings direct = settings();
  direct.linear_solver = LinearSolverKind::direct;
  EXPECT_LT(
      largest_difference(displacement_after_two_steps(direct), displacement_after_two_steps(settings())),
      1e-8);
}

TEST(Ranks, RunsAreTheSameToTheBit) {
  EXPECT_EQ(displacement_after_two_steps(settings()), displacement_after_two_steps(settings()));
}

TEST(Ranks, SeveralMoversLiveSideBySide) {
  auto first = make(box(), settings());
  auto second = make(box(), settings());
  step_to(*second, 1);
  second.reset();
  step_to(*first, 0.5);
  step_to(*first, 1);
  EXPECT_LT(
      largest_difference({first->displacement().begin(), first->displacement().end()}, alone(settings())),
      1e-9);
}

} // namespace
} // namespace drogue::mesh_mover

int main(int argc, char** argv) {
  using namespace drogue;
  testing::InitGoogleTest(&argc, argv);
  la::use_one_blas_thread();
  const auto session = la::Session::start();
  if (!session) return 1;
  if (la::rank() > 0) {
    mesh_mover::serve_extensions();
    return 0;
  }
  const int status = RUN_ALL_TESTS();
  mesh_mover::stop_other_ranks();
  return status;
}
