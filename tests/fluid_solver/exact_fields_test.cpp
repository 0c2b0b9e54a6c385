// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "fluid_solver/flow_solver.hpp"
#include "fluid_solver/space_time_element.hpp"
#include "fluid_solver/time_difference.hpp"
#include "tests/fluid_solver/box.hpp"

namespace drogue::fluid {
namespace {

using namespace test;

/// Runs three DSD/SST steps on a mesh that moves at random and returns the largest velocity error.
double error_on_moving_mesh(const Settings& settings, const config::VectorExpression& exact,
                            mesh::Mesh file = box_mesh({4, 3, 3}, {1, 0.8, 1.2})) {
  const auto mesh = FluidMesh::create(std::move(file));
  EXPECT_TRUE(mesh.ok());
  FlowSolver solver(settings, *mesh);
  const std::vector<double> zero(mesh->points.size(), 0.0);
  double worst = 0;
  for (unsigned step = 1; step <= 3; ++step) {
    EXPECT_TRUE(solver.begin_step({Formulation::dsd_sst, 1, step == 2 ? 3 : 2}, 0.1).ok());
    const std::vector<double> x = shaken(mesh->points, 0.03, step, mesh->dimension);
    EXPECT_TRUE(solver.set_end(x, zero, zero).ok());
    const auto report = solver.newton(settings.newton.max_iterations);
    EXPECT_TRUE(report.ok());
    EXPECT_TRUE(report.ok() && report->linear_converged);
    solver.commit();
    const FlowState& s = solver.state();
    for (std::size_t i = 0; i < s.u.size(); i += 3)
      for (std::size_t d = 0; d < 3; ++d)
        worst = std::max(worst, std::abs(s.u[i + d] - exact[d](s.x[i], s.x[i + 1], s.x[i + 2], s.time)));
  }
  return worst;
}

TEST(MovingMesh, UniformFlowStaysUniform) {
  Settings s = tight_settings(0.02);
  s.smagorinsky = 0.1;
  velocity_all_around(s, "1", "0.5", "-2");
  s.initial_velocity = vector_expression("1", "0.5", "-2");
  EXPECT_LT(error_on_moving_mesh(s, s.initial_velocity), 1e-9);
}

TEST(MovingMesh, SimpleShearStaysExact) {
  Settings s = tight_settings(0.02);
  velocity_all_around(s, "3*y", "0", "0");
  s.initial_velocity = vector_expression("3*y", "0", "0");
  EXPECT_LT(error_on_moving_mesh(s, s.initial_velocity), 1e-9);
}

TEST(MovingMesh, UniformAccelerationByABodyForceIsExact) {
  Settings s = tight_settings(0.02);
  velocity_all_around(s, "1+2*t", "-t", "0.5*t");
  s.initial_velocity = vector_expression("1", "0", "0");
  s.body_force = vector_expression("2", "-1", "0.5");
  EXPECT_LT(error_on_moving_mesh(s, vector_expression("1+2*t", "-t", "0.5*t")), 1e-9);
}

/// The same in two dimensions, by both linear solvers; uniform flow with every kind of boundary that lets it
/// be.
TEST(MovingMesh, PlaneFlowsStayExact) {
  for (const LinearMethod method : {LinearMethod::direct, LinearMethod::krylov}) {
    Settings s = tight_settings(0.02);
    s.linear_method = method;
    s.smagorinsky = 0.1;
    s.initial_velocity = vector_expression("1", "-0.5", "0");
    s.boundaries = {velocity("x0", "1", "-0.5", "0"), velocity("y0", "1", "-0.5", "0"),
                    velocity("y1", "1", "-0.5", "0"), boundary("x1", Condition::traction_free)};
    EXPECT_LT(error_on_moving_mesh(s, s.initial_velocity, rectangle_mesh({5, 4}, {1, 0.8})), 1e-10);

    s = tight_settings(0.02);
    s.linear_method = method;
    velocity_all_around(s, "3*y", "0");
    s.initial_velocity = vector_expression("3*y", "0", "0");
    EXPECT_LT(error_on_moving_mesh(s, s.initial_velocity, rectangle_mesh({5, 4}, {1, 0.8})), 1e-10);

    s = tight_settings(0.02);
    s.linear_method = method;
    velocity_all_around(s, "1+2*t", "-t");
    s.initial_velocity = vector_expression("1", "0", "0");
    s.body_force = vector_expression("2", "-1", "0");
    EXPECT_LT(error_on_moving_mesh(s, vector_expression("1+2*t", "-t", "0"),
                                   rectangle_mesh({5, 4}, {1, 0.8}, true)),
              1e-10);
  }
}

/// The exact shear on a moved mesh has no residual; without the mesh velocity in the advection it has one, so
/// the test above fails then.
TEST(MovingMesh, ShearIsWrongWhenTheMeshVelocityIsLeftOut) {
  const auto mesh = FluidMesh::create(box_mesh({2, 2, 2}, {1, 1, 1}));
  ASSERT_TRUE(mesh.ok());
  const std::vector<double> moved = shaken(mesh->points, 0.03, 5);
  const double dt = 0.1;
  const StandardCoefficients rule{{.dt = dt, .nu = 0.01, .tau_dt = dt}};
  std::vector<double> with(8 * static_cast<std::size_t>(mesh->node_count()), 0.0);
  std::vector<double> without(with);
  for (std::size_t e = 0; e < mesh->cells.size(); e += 4) {
    SpaceTimeValues<3, double> in{};
    for (int a = 0; a < 4; ++a) {
      const auto node = static_cast<std::size_t>(mesh->cells[e + static_cast<std::size_t>(a)]);
      for (std::size_t d = 0; d < 3; ++d) {
        in.x_n[a][d] = mesh->points[3 * node + d];
        in.x_np1[a][d] = moved[3 * node + d];
      }
      in.u_n[a][0] = in.w[a][0] = 3 * in.x_n[a][1];
      in.w[a][4] = 3 * in.x_np1[a][1];
    }
    double r[4][8];
    SlabInstants<3, 2, double> s;
    const auto add = [&](std::vector<double>& sum) {
      for (int a = 0; a < 4; ++a)
        for (std::size_t i = 0; i < 8; ++i)
          sum[8 * static_cast<std::size_t>(mesh->cells[e + static_cast<std::size_t>(a)]) + i] += r[a][i];
    };
    space_time_residual(in, rule.parameters, rule, r, s);
    add(with);
    space_time_residual<2, MeshVelocity::left_out>(in, rule.parameters, rule, r, s);
    add(without);
  }
  // the one node inside the box
  const auto inside = [&](std::size_t i) {
    for (std::size_t d = 0; d < 3; ++d)
      if (std::abs(mesh->points[3 * i + d] - 0.5) > 1e-9) return false;
    return true;
  };
  for (std::size_t i = 0; 3 * i < mesh->points.size(); ++i) {
    if (!inside(i)) continue;
    EXPECT_LT(std::abs(with[8 * i]) + std::abs(with[8 * i + 4]), 1e-12);
    EXPECT_GT(std::abs(without[8 * i]) + std::abs(without[8 * i + 4]), 1e-4);
  }
}

/// Order two is exact for velocities quadratic in time, but for the first step, which is of order one.
TEST(SemiDiscrete, TwoStepDifferenceIsExactForAParabolaInTime) {
  const TimeDifference d = two_step(0.1, 0.25);
  const auto u = [](double t) { return 3 + 2 * t - 5 * t * t; };
  EXPECT_NEAR(d.rate * u(0.7) + d.at_n * u(0.6) + d.before * u(0.35), 2 - 10 * 0.7, 1e-12);
}

TEST(SemiDiscrete, UniformAccelerationByABodyForceIsExact) {
  Settings s = tight_settings(0.02);
  velocity_all_around(s, "1+2*t", "-t", "0");
  s.initial_velocity = vector_expression("1", "0", "0");
  s.body_force = vector_expression("2", "-1", "0");
  const auto mesh = FluidMesh::create(box_mesh({3, 3, 3}, {1, 1, 1}));
  ASSERT_TRUE(mesh.ok());
  FlowSolver solver(s, *mesh);
  for (int step = 0; step < 2; ++step) {
    ASSERT_TRUE(solver.begin_step({Formulation::semi_discrete}, 0.1).ok());
    ASSERT_TRUE(solver.newton(30).ok());
    solver.commit();
  }
  for (std::size_t i = 0; i < solver.state().u.size(); i += 3) {
    EXPECT_NEAR(solver.state().u[i], 1.4, 1e-9);
    EXPECT_NEAR(solver.state().u[i + 1], -0.2, 1e-9);
  }
}

/// Fluid at rest in a closed box under gravity: the pressure is linear and exact in both formulations.
TEST(Hydrostatics, PressureIsExact) {
  for (const Formulation formulation : {Formulation::semi_discrete, Formulation::dsd_sst}) {
    Settings s = tight_settings(0.1);
    velocity_all_around(s, "0", "0", "0");
    s.body_force = vector_expression("0", "0", "-9.81");
    const auto mesh = FluidMesh::create(box_mesh({3, 3, 4}, {1, 1, 1}));
    ASSERT_TRUE(mesh.ok());
    FlowSolver solver(s, *mesh);
    ASSERT_TRUE(solver.begin_step({formulation}, 0.05).ok());
    ASSERT_TRUE(solver.newton(30).ok());
    const auto report = solver.finish();
    ASSERT_TRUE(report.ok());
    EXPECT_TRUE(report->converged);
    solver.commit();
    const FlowState& state = solver.state();
    for (std::size_t i = 0; i < state.p.size(); ++i) {
      EXPECT_NEAR(state.p[i], -9.81 * state.x[3 * i + 2], 1e-8);
      EXPECT_NEAR(state.u[3 * i + 2], 0, 1e-9);
    }
  }
}

} // namespace
} // namespace drogue::fluid
