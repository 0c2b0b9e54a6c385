// SPDX-License-Identifier: GPL-3.0-or-later
//
// The mesh motion against exact answers: affine motions of the boundary (patch test) in two and three
// dimensions, and a sphere that is carried two diameters through a box while it turns by 90 degrees, and
// back.
#include "tests/mesh_mover/mover_cases.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/mesh_domains.hpp"

namespace drogue::mesh_mover {
namespace {

using drogue::test::verify;
using drogue::test::verify_between;

struct PatchCase {
  std::string name;
  mesh::Mesh (*mesh)();
  std::vector<std::string> groups;
  std::string z;
};
const PatchCase plate = {"2d", test::plate_in_square, {"plate", "outer"}, "0"};
const PatchCase sphere = {
    "3d", test::sphere_in_box, {"sphere", "outer"}, "t*(0.05 - 0.03*x + 0.02*y + 0.04*z)"};

/// Largest distance from the affine motion after three steps.
double patch_error(const PatchCase& patch, Settings settings) {
  for (const auto& group : patch.groups)
    settings.boundaries.push_back(
        moved(group, "t*(0.1 + 0.05*x - 0.08*y + 0.02*z)", "t*(0.03*x + 0.04*y - 0.2 - 0.05*z)", patch.z));
  settings.tolerance = 1e-13;
  settings.max_iterations = 5000;
  const auto mover = make(patch.mesh(), settings);
  double error = 0;
  for (int t = 1; t <= 3; ++t) {
    step_to(*mover, t);
    error = std::max(error, largest_error(*mover, [&](const double* X) -> std::array<double, 3> {
                       return {t * (0.1 + 0.05 * X[0] - 0.08 * X[1] + 0.02 * X[2]),
                               t * (0.03 * X[0] + 0.04 * X[1] - 0.2 - 0.05 * X[2]),
                               patch.z == "0" ? 0 : t * (0.05 - 0.03 * X[0] + 0.02 * X[1] + 0.04 * X[2])};
                     }));
  }
  return error;
}

TEST(Patch, PlainElasticityReproducesAffineMotions) {
  for (const PatchCase& patch : {plate, sphere})
    for (const auto increment : {Increment::from_last_step, Increment::from_initial})
      for (const auto solver : {LinearSolverKind::direct, LinearSolverKind::iterative}) {
        if (solver == LinearSolverKind::direct && patch.name == "3d") continue; // for small meshes only
        Settings settings;
        settings.stiffening_exponent = 0;
        settings.increment = increment;
        settings.linear_solver = solver;
        verify(fmt::format("mesh/patch_{}_{}_{}", patch.name,
                           increment == Increment::from_initial ? "from_initial" : "from_last_step",
                           solver == LinearSolverKind::direct ? "direct" : "iterative"),
               "error", patch_error(patch, settings), 0, 1e-10);
      }
}

TEST(Patch, AlgebraicMethodReproducesAffineMotionsOfFullBodies) {
  for (const auto increment : {Increment::from_last_step, Increment::from_initial}) {
    Settings settings;
    settings.method = Method::algebraic;
    settings.increment = increment;
    verify(fmt::format("mesh/patch_3d_{}_algebraic",
                       increment == Increment::from_initial ? "from_initial" : "from_last_step"),
           "error", patch_error(sphere, settings), 0, 1e-10);
  }
}

constexpr int steps = 20;

Settings moving_sphere(Increment increment) {
  Settings settings;
  settings.boundaries = {boundary("outer", Condition::fixed),
                         moved("sphere", "2*t + x*(cos(pi/2*t) - 1) - y*sin(pi/2*t)",
                               "x*sin(pi/2*t) + y*(cos(pi/2*t) - 1)", "0")};
  settings.increment = increment;
  settings.max_sub_increments = 16; // from the initial mesh the whole way at once inverts elements
  settings.tolerance = 1e-10;
  settings.stop.min_volume_ratio = 0;
  return settings;
}

void verify_sphere(const std::string& name, Increment increment) {
  const auto mover = make(test::sphere_in_box(), moving_sphere(increment));
  SolveReport report;
  double worst_volume = 1;
  for (int step = 1; step <= 2 * steps; ++step) {
    const double t = 1 - std::abs(1 - static_cast<double>(step) / steps);
    report = step_to(*mover, t);
    worst_volume = std::min(worst_volume, report.quality.min_volume_ratio);
    if (step != steps) continue;
    verify_between(name, "smallest_volume_ratio", worst_volume, 0.01, 1);
    verify_between(name, "f_A", report.quality.f_A, 0, 6);
    verify_between(name, "f_AR", report.quality.f_AR, 0, 6);
    verify_between(name, "smallest_angle", report.quality.smallest_angle, 1, 70);
  }
  const double distance = largest_error(*mover, [](const double*) -> std::array<double, 3> { return {}; });
  if (increment == Increment::from_initial)
    verify(name + "_and_back", "distance", distance, 0, 1e-12);
  else
    verify_between(name + "_and_back", "f_A", report.quality.f_A, 0, 4);
}

TEST(Sphere, TwoDiametersAndAQuarterTurnFromStepToStep) {
  verify_sphere("mesh/sphere_from_last_step", Increment::from_last_step);
}

TEST(Sphere, TwoDiametersAndAQuarterTurnFromTheInitialMesh) {
  verify_sphere("mesh/sphere_from_initial", Increment::from_initial);
}

} // namespace
} // namespace drogue::mesh_mover
