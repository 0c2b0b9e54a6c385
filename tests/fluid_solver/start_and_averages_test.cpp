// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "fluid_solver/averages.hpp"
#include "fluid_solver/consistent_traction.hpp"
#include "tests/fluid_solver/box.hpp"

/// Divergence-free starts, ways to iterate, averages, and the load that the discrete equations exert.
namespace drogue::fluid {
namespace {

using namespace test;

Settings plane_channel() {
  Settings s = tight_settings(0.02);
  s.linear_method = LinearMethod::direct;
  s.boundaries = {velocity("x0", "1", "0", "0"), boundary("x1", Condition::traction_free),
                  boundary("y0", Condition::free_slip), boundary("y1", Condition::free_slip)};
  return s;
}

/// (1, 0) + grad phi, phi zero at the outflow, projects on (1, 0).
double projection_error(int cells) {
  Settings s = plane_channel();
  s.initial_velocity = vector_expression("1-0.2*cos(pi*y)", "-0.2*pi*(1-x)*sin(pi*y)", "0");
  s.initial_pressure = config::Expression::parse("3").value();
  const auto mesh = FluidMesh::create(rectangle_mesh({cells, cells}, {1, 1}));
  EXPECT_TRUE(mesh.ok());
  FlowSolver solver(s, *mesh);
  EXPECT_TRUE(solver.project_velocity().ok());
  EXPECT_EQ(solver.state().step, 0U);
  EXPECT_EQ(solver.state().time, 0.0);
  EXPECT_EQ(solver.state().p[0], 1.5); // kinematic, untouched
  double square = 0;
  for (std::size_t i = 0; i < solver.state().u.size(); i += 3)
    square += std::pow(solver.state().u[i] - 1, 2) + std::pow(solver.state().u[i + 1], 2);
  return std::sqrt(square / mesh->node_count());
}

TEST(InitialFlow, ProjectionTakesAGradientOut) {
  const double coarse = projection_error(8);
  const double fine = projection_error(16);
  EXPECT_LT(fine, 0.01); // of 0.3 before
  EXPECT_GT(coarse / fine, 2.5);
}

std::vector<double> velocity_after_a_step(const Settings& s, const FluidMesh& mesh) {
  FlowSolver solver(s, mesh);
  EXPECT_TRUE(solver.begin_step({Formulation::dsd_sst}, 0.2).ok());
  const auto report = solver.newton(60, true);
  EXPECT_TRUE(report.ok());
  EXPECT_TRUE(solver.finish().ok());
  solver.commit();
  return solver.state().u;
}

TEST(Iterations, PicardAndLineSearchReachWhatNewtonReaches) {
  Settings s = tight_settings(0.02);
  s.linear_method = LinearMethod::direct;
  velocity_all_around(s, "sin(3*y)*(1+t)", "x*x*(1+t)");
  s.boundaries[1] = boundary("x1", Condition::traction_free);
  s.initial_velocity = vector_expression("sin(3*y)", "x*x", "0");
  const auto mesh = FluidMesh::create(rectangle_mesh({6, 6}, {1, 1}));
  ASSERT_TRUE(mesh.ok());
  const std::vector<double> newton = velocity_after_a_step(s, *mesh);
  s.newton.shortest_correction = 0.1;
  const std::vector<double> searched = velocity_after_a_step(s, *mesh);
  s.newton.picard = true;
  const std::vector<double> picard = velocity_after_a_step(s, *mesh);
  for (std::size_t i = 0; i < newton.size(); ++i) {
    EXPECT_NEAR(searched[i], newton[i], 1e-8);
    EXPECT_NEAR(picard[i], newton[i], 1e-8);
  }
}

TEST(Averages, AreThoseOfTheWeightedSamplesAndGoOnFromAState) {
  const double dt[] = {0.1, 0.3, 0.2, 0.4};
  const double value[] = {5, -1, 2, 1e3};
  RunningMoments whole;
  RunningMoments first;
  double mean = 0;
  double square = 0;
  for (int k = 0; k < 4; ++k) {
    mean += dt[k] * value[k];
    whole.add(dt[k], {{value[k], -value[k]}});
    if (k < 2) first.add(dt[k], {{value[k], -value[k]}});
  }
  for (int k = 0; k < 4; ++k) square += dt[k] * std::pow(value[k] - mean, 2);
  EXPECT_NEAR(whole.weight(), 1.0, 1e-14);
  EXPECT_NEAR(whole.mean()[0], mean, 1e-12 * mean);
  EXPECT_NEAR(whole.mean()[1], -mean, 1e-12 * mean);
  EXPECT_NEAR(whole.rms()[0], std::sqrt(square), 1e-12 * mean);

  const auto same = [](const std::vector<double>& v) { return v; };
  io::State state;
  first.save("u", state, same);
  RunningMoments second;
  second.load("u", state, same);
  for (int k = 2; k < 4; ++k) second.add(dt[k], {{value[k], -value[k]}});
  EXPECT_EQ(second.mean(), whole.mean());
  EXPECT_EQ(second.rms(), whole.rms());
}

/// Water at rest between frictionless walls: the floor carries the weight, the traction is the pressure.
template <class Mesh>
void expect_hydrostatic_traction(const Mesh& file, const char* floor, int up, Formulation formulation) {
  Settings s = tight_settings(0.1);
  for (const mesh::ElementBlock& block : file.blocks)
    if (block.group != "fluid") s.boundaries.push_back(boundary(block.group, Condition::free_slip));
  for (BoundarySettings& b : s.boundaries)
    if (b.name == floor) b.condition = Condition::no_slip;
  s.body_force[static_cast<std::size_t>(up)] = config::Expression::parse("-9.81").value();
  const auto mesh = FluidMesh::create(file);
  ASSERT_TRUE(mesh.ok());
  FlowSolver solver(s, *mesh);
  ASSERT_TRUE(solver.begin_step({formulation}, 0.05).ok());
  ASSERT_TRUE(solver.newton(40, true).ok());
  ASSERT_TRUE(solver.finish().ok());
  const std::vector<double> forces = nodal_forces(s, *mesh, solver);
  const auto boundaries = boundary_indices(*mesh, std::vector<std::string>{floor});
  const auto nodes = mesh->nodes_of(boundaries);
  const auto traction = traction_of(forces, *mesh, mesh->points, boundaries, nodes);
  ASSERT_TRUE(traction.ok());
  const std::vector<double> p = solver.pressure_np1();
  for (std::size_t k = 0; k < nodes.size(); ++k) // the floor's normal out of the fluid points down
    EXPECT_NEAR((*traction)[3 * k + static_cast<std::size_t>(up)],
                -s.density * p[static_cast<std::size_t>(nodes[k])], 1e-6);
}

TEST(ConsistentTraction, IsThePressureOfAFluidAtRest) {
  for (const Formulation formulation : {Formulation::semi_discrete, Formulation::dsd_sst}) {
    expect_hydrostatic_traction(rectangle_mesh({5, 4}, {1, 1}), "y0", 1, formulation);
    expect_hydrostatic_traction(box_mesh({3, 3, 3}, {1, 1, 1}), "z0", 2, formulation);
  }
}

} // namespace
} // namespace drogue::fluid
