// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fluid_solver/flow_fields.hpp"
#include "fluid_solver/flow_solver.hpp"
#include "tests/fluid_solver/box.hpp"

/// Free slip on planes of any orientation and on curved surfaces.
namespace drogue::fluid {
namespace {

using namespace test;
using Vector = std::array<double, 3>;

constexpr Formulation formulations[] = {Formulation::semi_discrete, Formulation::dsd_sst};

/// A rotation about an oblique axis.
Vector turned(const Vector& v) {
  constexpr double R[3][3] = {
      {2.0 / 3, -1.0 / 3, 2.0 / 3}, {2.0 / 3, 2.0 / 3, -1.0 / 3}, {-1.0 / 3, 2.0 / 3, 2.0 / 3}};
  Vector r{};
  for (std::size_t i = 0; i < 3; ++i) r[i] = R[i][0] * v[0] + R[i][1] * v[1] + R[i][2] * v[2];
  return r;
}

std::vector<double> turned(std::vector<double> values) {
  for (std::size_t i = 0; i < values.size(); i += 3) {
    const Vector v = turned(Vector{values[i], values[i + 1], values[i + 2]});
    std::copy(v.begin(), v.end(), values.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return values;
}

config::VectorExpression constant(const Vector& v) {
  return vector_expression(std::to_string(v[0]), std::to_string(v[1]), std::to_string(v[2]));
}

mesh::Mesh turned(mesh::Mesh m) {
  m.points = turned(std::move(m.points));
  return m;
}

FluidMesh made(mesh::Mesh m) {
  auto mesh = FluidMesh::create(std::move(m));
  EXPECT_TRUE(mesh.ok());
  return std::move(*mesh);
}

/// A box whose nodes move at random, those on its sides within them.
std::vector<double> shaken_inside(const std::vector<double>& box, const Vector& size, double amount,
                                  unsigned seed) {
  std::vector<double> points = shaken(box, amount, seed);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (box[i] < 1e-12 || box[i] > size[i % 3] - 1e-12) points[i] = box[i];
  return points;
}

/// One step to convergence.
void step(FlowSolver& solver, Formulation formulation, double dt, std::span<const double> x,
          std::span<const double> wall) {
  ASSERT_TRUE(solver.begin_step({formulation}, dt).ok());
  ASSERT_TRUE(solver.set_end(x, wall, wall).ok());
  const auto report = solver.newton(30);
  ASSERT_TRUE(report.ok() && report->linear_converged);
  ASSERT_TRUE(solver.finish().ok());
  solver.commit();
}

/// A cylinder of radius 1 about z, 0 <= z <= height, in n x n x layers cells; equal angles on the circle.
/// Boundaries z0, z1 and the four quarters x0, x1, y0, y1 of its side.
mesh::Mesh cylinder_mesh(int n, int layers, double height) {
  mesh::Mesh m = box_mesh({n, n, layers}, {2, 2, height}, true);
  for (std::size_t i = 0; i < m.points.size(); i += 3) {
    const double a = m.points[i] - 1;
    const double b = m.points[i + 1] - 1;
    const double r = std::max(std::abs(a), std::abs(b));
    const double quarter = std::numbers::pi / 4;
    double angle = 0;
    if (r > 0 && std::abs(a) >= std::abs(b)) angle = quarter * b / a + (a < 0 ? std::numbers::pi : 0);
    if (r > 0 && std::abs(a) < std::abs(b)) angle = quarter * (2 - a / b) + (b < 0 ? std::numbers::pi : 0);
    m.points[i] = r * std::cos(angle);
    m.points[i + 1] = r * std::sin(angle);
  }
  return m;
}

Settings all_slip(double dynamic_viscosity) {
  Settings s = tight_settings(dynamic_viscosity);
  for (const char* name : {"x0", "x1", "y0", "y1", "z0", "z1"})
    s.boundaries.push_back(boundary(name, Condition::free_slip));
  return s;
}

std::vector<SlipDirections> directions(const Settings& s, const FluidMesh& mesh) {
  std::vector<double> u(mesh.points.size(), 0.0);
  return VelocityConstraints(s, mesh).apply(0, mesh.points, u, u, 3, 0);
}

TEST(SlipNormals, SidesEdgesAndCornersOfATurnedBoxHoldOneTwoAndThreeDirections) {
  const mesh::Mesh box = box_mesh({2, 3, 2}, {1, 1, 1});
  const FluidMesh mesh = made(turned(box));
  int nodes_with[4] = {};
  for (const SlipDirections& held : directions(all_slip(1), mesh)) {
    const std::size_t i = 3 * static_cast<std::size_t>(mesh.to_file[static_cast<std::size_t>(held.node)]);
    int sides = 0;
    for (std::size_t d = 0; d < 3; ++d) {
      if (box.points[i + d] > 1e-12 && box.points[i + d] < 1 - 1e-12) continue;
      ++sides;
      Vector normal{};
      normal[d] = 1;
      normal = turned(normal);
      held.project(normal.data());
      EXPECT_LT(std::hypot(normal[0], normal[1], normal[2]), 1e-14);
    }
    EXPECT_EQ(held.count, sides);
    ++nodes_with[held.count];
  }
  EXPECT_EQ(nodes_with[1], 10); // 2 x 2 x 1 + 1 x 2 + ... inside the six sides
  EXPECT_EQ(nodes_with[2], 16);
  EXPECT_EQ(nodes_with[3], 8);
}

TEST(SlipNormals, ACylinderHasOneRadialNormalANodeAndTwoDirectionsOnItsRim) {
  const FluidMesh mesh = made(cylinder_mesh(8, 3, 1));
  for (const SlipDirections& held : directions(all_slip(1), mesh)) {
    const double* x = mesh.points.data() + 3 * static_cast<std::size_t>(held.node);
    const bool side = std::hypot(x[0], x[1]) > 1 - 1e-9;
    const bool end = x[2] < 1e-9 || x[2] > 1 - 1e-9;
    EXPECT_EQ(held.count, int{side} + int{end});
    Vector radial{x[0], x[1], 0};
    held.project(radial.data());
    EXPECT_TRUE(!side || std::hypot(radial[0], radial[1], radial[2]) < 1e-12);
  }
}

TEST(SlipNormals, NoSlipAndVelocityWinOverSlip) {
  Settings s = all_slip(1);
  s.boundaries[0] = boundary("x0", Condition::no_slip);
  s.boundaries[5] = velocity("z1", "1", "2", "3");
  const FluidMesh mesh = made(turned(box_mesh({2, 2, 2}, {1, 1, 1})));
  const VelocityConstraints constraints(s, mesh);
  const auto no_slip = mesh.nodes_of(boundary_indices(mesh, std::vector<std::string>{"x0", "z1"}));
  for (const std::int32_t node : no_slip)
    EXPECT_FALSE(std::binary_search(constraints.slip_nodes().begin(), constraints.slip_nodes().end(), node));
  EXPECT_EQ(constraints.slip_nodes().size() + no_slip.size(), 26U); // all but the node inside
}

/// Half the components from a wall, the rest from slip: x held by a no-slip wall on an oblique plane.
TEST(SlipNormals, ComponentsHeldByAWallAreKept) {
  Settings s = all_slip(1);
  s.boundaries[0] = boundary("x0", Condition::no_slip);
  s.boundaries[0].components = {true, false, false};
  const FluidMesh mesh = made(turned(box_mesh({1, 1, 1}, {1, 1, 1})));
  std::vector<double> u(mesh.points.size(), 0.7);
  const std::vector<double> wall(mesh.points.size(), 0.3);
  const auto held = VelocityConstraints(s, mesh).apply(0, mesh.points, wall, u, 3, 0);
  const auto x0 = mesh.nodes_of(boundary_indices(mesh, std::vector<std::string>{"x0"}));
  for (const SlipDirections& directions : held) {
    const double* v = u.data() + 3 * static_cast<std::size_t>(directions.node);
    if (!std::binary_search(x0.begin(), x0.end(), directions.node)) continue;
    EXPECT_EQ(v[0], 0.3);
    for (int k = 0; k < directions.count; ++k) EXPECT_NEAR(directions.n[k][0], 0, 1e-15);
    EXPECT_EQ(directions.count, 2); // in a corner of the box
    const Vector y = turned(Vector{0, 1, 0});
    EXPECT_NEAR(v[0] * y[0] + v[1] * y[1] + v[2] * y[2], 0, 1e-14);
  }
}

/// A uniform flow along a turned channel, on a mesh that rests or moves at random within the walls.
double channel_error(Formulation formulation, bool moving) {
  const Vector size{1, 0.8, 1.2};
  const mesh::Mesh box = box_mesh({4, 3, 3}, size);
  const FluidMesh mesh = made(turned(box));
  const Vector u = turned(Vector{2.25, 0, 0}); // 1.5 (1, 1, -1/2)
  Settings s = all_slip(0.02);
  s.smagorinsky = 0.1;
  s.boundaries[0] = boundary("x0", Condition::velocity);
  s.boundaries[0].value = constant(u);
  s.boundaries[1] = boundary("x1", Condition::traction_free);
  s.boundaries[1].backflow = 0.5;
  s.initial_velocity = constant(u);
  FlowSolver solver(s, mesh);
  const std::vector<double> zero(mesh.points.size(), 0.0);
  double worst = 0;
  for (unsigned k = 1; k <= 3; ++k) {
    const auto points = moving ? turned(shaken_inside(box.points, size, 0.03, k)) : turned(box.points);
    step(solver, formulation, 0.1, mesh.reordered_from_file(points, 3), zero);
    for (std::size_t i = 0; i < zero.size(); ++i)
      worst = std::max(worst, std::abs(solver.state().u[i] - u[i % 3]));
  }
  return worst;
}

TEST(Slip, AUniformFlowAlongATurnedChannelIsKept) {
  for (const Formulation formulation : formulations) EXPECT_LT(channel_error(formulation, false), 1e-10);
  EXPECT_LT(channel_error(Formulation::dsd_sst, true), 1e-10);
}

/// Flow past a no-slip wall between slip walls: state after steps of both formulations, the last ones on a
/// moving mesh.
FlowState flow_past_a_wall(bool turn) {
  const auto oriented = [&](const Vector& v) { return turn ? turned(v) : v; };
  const Vector size{1, 0.9, 1.5};
  const mesh::Mesh box = box_mesh({3, 3, 5}, size);
  const FluidMesh mesh = made(turn ? turned(box) : box);
  Settings s = all_slip(0.05);
  s.smagorinsky = 0.1;
  s.newton = {1e-13, 12, 0.5, 1, 1};
  s.boundaries[0] = boundary("x0", Condition::no_slip);
  s.boundaries[4] = boundary("z0", Condition::velocity);
  s.boundaries[4].value = constant(oriented({0.375, 0, 1.5}));
  s.boundaries[5] = boundary("z1", Condition::traction_free);
  s.body_force = constant(oriented({0.75, 0, 0.375}));
  s.initial_velocity = constant(oriented({0, 0, 1.5}));
  FlowSolver solver(s, mesh);
  for (unsigned k = 0; k < 4; ++k) {
    std::vector<double> points = shaken_inside(box.points, size, k < 2 ? 0.0 : 0.02, k);
    points = mesh.reordered_from_file(turn ? turned(points) : points, 3);
    const std::vector<double> rest(points.size(), 0.0);
    step(solver, k < 2 ? Formulation::semi_discrete : Formulation::dsd_sst, 0.1, points, rest);
  }
  return solver.state();
}

TEST(Slip, ATurnedProblemHasTheTurnedSolution) {
  const FlowState straight = flow_past_a_wall(false);
  const FlowState oblique = flow_past_a_wall(true);
  const std::vector<double> expected = turned(straight.u);
  double largest = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(oblique.u[i], expected[i], 1e-9);
    largest = std::max(largest, std::abs(straight.u[i]));
  }
  for (std::size_t i = 0; i < straight.p.size(); ++i) EXPECT_NEAR(oblique.p[i], straight.p[i], 1e-8);
  EXPECT_GT(largest, 1.5);
}

/// A viscous fluid turns like a rigid body in a frictionless cylinder that is oblique to the axes; the body
/// force -omega^2 r holds it together, so that the pressure is constant and the flow exact. In the space-time
/// formulation the mesh turns along, at another speed, and its inner nodes shake: the normals turn as well.
double error_in_a_cylinder(Formulation formulation) {
  const mesh::Mesh upright = cylinder_mesh(6, 2, 1);
  const FluidMesh mesh = made(turned(upright));
  Settings s = all_slip(0.3);
  const double omega = 3;
  const auto rotation = [&](const Vector& x) { // omega e x x, e = turned z
    const Vector e = turned(Vector{0, 0, omega});
    return Vector{e[1] * x[2] - e[2] * x[1], e[2] * x[0] - e[0] * x[2], e[0] * x[1] - e[1] * x[0]};
  };
  // turned z = (2, -1, 2) / 3
  s.initial_velocity = vector_expression("-z-2*y", "2*x-2*z", "2*y+x");
  s.body_force = vector_expression("-9*x+2*(2*x-y+2*z)", "-9*y-(2*x-y+2*z)", "-9*z+2*(2*x-y+2*z)");
  FlowSolver solver(s, mesh);
  const std::vector<double> rest(mesh.points.size(), 0.0);
  double worst = 0;
  for (unsigned k = 1; k <= 3; ++k) {
    std::vector<double> points = upright.points;
    if (formulation == Formulation::dsd_sst) {
      const std::vector<double> moved = shaken(points, 0.02, k);
      const double angle = 0.1 * k;
      for (std::size_t i = 0; i < points.size(); i += 3) {
        const bool inside = std::hypot(points[i], points[i + 1]) < 0.99;
        const double x = inside ? moved[i] : points[i];
        const double y = inside ? moved[i + 1] : points[i + 1];
        points[i] = x * std::cos(angle) - y * std::sin(angle);
        points[i + 1] = x * std::sin(angle) + y * std::cos(angle);
      }
    }
    step(solver, formulation, 0.1, mesh.reordered_from_file(turned(points), 3), rest);
    const FlowState& state = solver.state();
    for (std::size_t i = 0; i < rest.size(); i += 3) {
      const Vector exact = rotation({state.x[i], state.x[i + 1], state.x[i + 2]});
      for (std::size_t d = 0; d < 3; ++d) worst = std::max(worst, std::abs(state.u[i + d] - exact[d]));
    }
  }
  return worst;
}

TEST(Slip, AFluidTurnsLikeARigidBodyInAFrictionlessCylinder) {
  for (const Formulation formulation : formulations) EXPECT_LT(error_in_a_cylinder(formulation), 1e-9);
}

/// Through a channel with a hump in its frictionless floor nothing leaks, and the flow speeds up above it.
TEST(Slip, NothingFlowsThroughACurvedWall) {
  mesh::Mesh humped = box_mesh({10, 2, 4}, {3, 0.5, 1});
  for (std::size_t i = 0; i < humped.points.size(); i += 3) {
    const double along = std::clamp((humped.points[i] - 0.3) / 2.4, 0.0, 1.0);
    const double hump = 0.25 * std::pow(std::sin(std::numbers::pi * along), 2);
    humped.points[i + 2] += hump * (1 - humped.points[i + 2]);
  }
  const FluidMesh mesh = made(humped);
  Settings s = all_slip(0.01);
  s.boundaries[0] = velocity("x0", "1", "0", "0");
  s.boundaries[1] = boundary("x1", Condition::traction_free);
  s.initial_velocity = vector_expression("1", "0", "0");
  s.newton = {1e-10, 10, 0.5, 1, 1};
  FlowSolver solver(s, mesh);
  const std::vector<double> rest(mesh.points.size(), 0.0);
  for (int k = 0; k < 6; ++k) step(solver, formulations[k % 2], 0.2, mesh.points, rest);
  const FlowState& state = solver.state();
  const auto floor = boundary_indices(mesh, std::vector<std::string>{"z0"});
  double flux = 0;
  double fastest = 0;
  for (const BoundaryFace& face : mesh.faces) {
    if (face.boundary != floor[0]) continue;
    const auto area = area_vector(face, state.x);
    for (const std::int32_t node : face.nodes())
      for (std::size_t d = 0; d < 3; ++d)
        flux += state.u[3 * static_cast<std::size_t>(node) + d] * area[d] / 3;
  }
  for (std::size_t i = 0; i < state.u.size(); i += 3) fastest = std::max(fastest, state.u[i]);
  EXPECT_LT(std::abs(flux), 1e-12);
  EXPECT_LT(std::abs(mass_imbalance(mesh, state.x, state.u)), 1e-6);
  EXPECT_GT(fastest, 1.2); // 4/3 in the mean of the throat
  EXPECT_LT(fastest, 1.8);
}

/// A frictionless wall that moves takes the fluid along: a plug behind a piston, oblique to the axes.
TEST(Slip, AWallPushesTheFluidByItsNormalMotion) {
  const mesh::Mesh box = box_mesh({3, 2, 2}, {1, 1, 1});
  const FluidMesh mesh = made(turned(box));
  Settings s = all_slip(0.05);
  s.boundaries[0].slip_wall = true;
  s.boundaries[1] = boundary("x1", Condition::traction_free);
  const Vector u = turned(Vector{0.75, 0, 0});
  s.initial_velocity = constant(u);
  FlowSolver solver(s, mesh);
  const Vector sideways = turned(Vector{0.75, 0.3, -0.2}); // its tangential motion moves nothing
  std::vector<double> wall(mesh.points.size());
  for (std::size_t i = 0; i < wall.size(); ++i) wall[i] = sideways[i % 3];
  for (int k = 1; k <= 2; ++k) {
    std::vector<double> points = box.points;
    for (std::size_t i = 0; i < points.size(); i += 3) points[i] += 0.05 * 0.75 * k * (1 - box.points[i]);
    step(solver, Formulation::dsd_sst, 0.05, mesh.reordered_from_file(turned(points), 3), wall);
  }
  for (std::size_t i = 0; i < wall.size(); ++i) EXPECT_NEAR(solver.state().u[i], u[i % 3], 1e-10);
}

} // namespace
} // namespace drogue::fluid
