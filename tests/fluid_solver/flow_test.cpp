// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "fluid_solver/coupled_flow.hpp"
#include "fluid_solver/flow_fields.hpp"
#include "fluid_solver/forces.hpp"
#include "fluid_solver/open_boundary.hpp"
#include "tests/fluid_solver/box.hpp"

namespace drogue::fluid {
namespace {

using namespace test;

/// Decaying vortices u = sin x cos y exp(-2 nu t), v = -cos x sin y exp(-2 nu t): error of the velocity at t
/// = 0.4, root mean square over the nodes, with n cells along pi and n/3 steps.
double vortex_error(int n, Formulation formulation) {
  constexpr double pi = std::numbers::pi;
  Settings s = tight_settings(0.1); // nu = 0.05
  s.newton = {1e-8, 10, 0.5, 1, 1};
  velocity_all_around(s, "sin(x)*cos(y)*exp(-0.1*t)", "-cos(x)*sin(y)*exp(-0.1*t)", "0");
  s.initial_velocity = vector_expression("sin(x)*cos(y)", "-cos(x)*sin(y)", "0");
  s.initial_pressure = config::Expression::parse("0.5*(cos(2*x)+cos(2*y))").value(); // density 2
  const auto mesh = FluidMesh::create(box_mesh({n, n, n / 3}, {pi, pi, pi / 3}));
  EXPECT_TRUE(mesh.ok());
  FlowSolver solver(s, *mesh);
  const int steps = n / 3;
  for (int k = 0; k < steps; ++k) {
    EXPECT_TRUE(solver.begin_step({formulation}, 0.4 / steps).ok());
    const auto report = solver.newton(10);
    EXPECT_TRUE(report.ok() && report->converged);
    solver.commit();
  }
  const FlowState& state = solver.state();
  double square = 0;
  for (std::size_t i = 0; i < state.u.size(); i += 3) {
    const double decay = std::exp(-0.1 * state.time);
    square += std::pow(state.u[i] - std::sin(state.x[i]) * std::cos(state.x[i + 1]) * decay, 2);
    square += std::pow(state.u[i + 1] + std::cos(state.x[i]) * std::sin(state.x[i + 1]) * decay, 2);
    square += std::pow(state.u[i + 2], 2);
  }
  return std::sqrt(square / mesh->node_count());
}

TEST(DecayingVortices, SpaceTimeIsOfSecondOrder) {
  const double order =
      std::log2(vortex_error(6, Formulation::dsd_sst) / vortex_error(12, Formulation::dsd_sst));
  RecordProperty("order", std::to_string(order));
  EXPECT_GT(order, 1.7);
  EXPECT_LT(order, 3.0);
}

TEST(DecayingVortices, SemiDiscreteConverges) {
  const double order =
      std::log2(vortex_error(6, Formulation::semi_discrete) / vortex_error(12, Formulation::semi_discrete));
  EXPECT_GT(order, 0.9); // first order in time, second in space
  EXPECT_LT(order, 3.0);
}

TEST(Forces, WallsOfAClosedBoxCarryTheWeight) {
  Settings s = tight_settings(0.1);
  velocity_all_around(s, "0", "0", "0");
  s.body_force = vector_expression("0", "0", "-9.81");
  const std::vector<std::string> walls{"x0", "x1", "y0", "y1", "z0", "z1"};
  s.forces = {{"walls", walls, 0}, {"walls_about_the_middle", walls, 0, {0.5, 0.5, 0.7}}};
  const auto mesh = FluidMesh::create(box_mesh({3, 3, 4}, {1, 1, 1.5}));
  ASSERT_TRUE(mesh.ok());
  for (const Formulation formulation : {Formulation::semi_discrete, Formulation::dsd_sst}) {
    FlowSolver solver(s, *mesh);
    ASSERT_TRUE(solver.begin_step({formulation}, 0.05).ok());
    ASSERT_TRUE(solver.newton(30).ok());
    ASSERT_TRUE(solver.finish().ok());
    const auto forces = surface_forces(s, *mesh, solver);
    const double weight = 2 * 1.5 * 9.81;
    EXPECT_NEAR(forces[0].pressure[2], -weight, 1e-7);
    EXPECT_NEAR(forces[0].reaction[2], -weight, 1e-7);
    EXPECT_NEAR(forces[0].reaction[0], 0, 1e-7);
    EXPECT_NEAR(forces[0].viscous[2], 0, 1e-7);
    const double moment[3] = {-0.5 * weight, 0.5 * weight, 0}; // of the weight in (0.5, 0.5)
    for (std::size_t d = 0; d < 3; ++d) {
      EXPECT_NEAR(forces[0].moment[d], moment[d], 1e-7);
      EXPECT_NEAR(forces[1].moment[d], 0, 1e-7);
    }
  }
}

TEST(Forces, ShearFlowDragsTheWall) {
  Settings s = tight_settings(0.3);
  velocity_all_around(s, "4*y", "0", "0");
  s.initial_velocity = vector_expression("4*y", "0", "0");
  s.forces = {{"lower", {"y0"}, 0}, {"upper", {"y1"}, 0}};
  const auto mesh = FluidMesh::create(box_mesh({3, 3, 3}, {2, 1, 1}));
  ASSERT_TRUE(mesh.ok());
  FlowSolver solver(s, *mesh);
  ASSERT_TRUE(solver.begin_step({Formulation::dsd_sst}, 0.1).ok());
  ASSERT_TRUE(solver.newton(30).ok());
  ASSERT_TRUE(solver.finish().ok());
  const auto forces = surface_forces(s, *mesh, solver);
  const double drag = 0.3 * 4 * 2; // mu gamma A
  EXPECT_NEAR(forces[0].viscous[0], drag, 1e-9);
  EXPECT_NEAR(forces[0].reaction[0], drag, 1e-8);
  EXPECT_NEAR(forces[0].moment[1], 0.5 * drag, 1e-8); // the wall's middle has z = 0.5
  EXPECT_NEAR(forces[1].moment[2], drag, 1e-8);       // and the upper one y = 1
  EXPECT_NEAR(forces[1].viscous[0], -drag, 1e-9);
  EXPECT_NEAR(forces[1].reaction[0], -drag, 1e-8);
}

/// A channel: inflow at z0, open at z1, a wall at x0, slip elsewhere. Everything a T-10 run uses.
Settings channel() {
  Settings s = tight_settings(0.02);
  s.newton = {1e-6, 6, 0.5, 2, 100};
  s.linear = {1e-3, 300, 60};
  s.smagorinsky = 0.1;
  s.boundaries = {velocity("z0", "0", "0", "1+0.2*sin(3*t)"), boundary("z1", Condition::traction_free),
                  boundary("x0", Condition::no_slip),         boundary("x1", Condition::free_slip),
                  boundary("y0", Condition::free_slip),       boundary("y1", Condition::free_slip)};
  s.boundaries[1].backflow = 0.5;
  s.initial_velocity = vector_expression("0", "0", "1");
  s.phases.resize(1);
  return s;
}

TEST(Restart, FourStepsEqualTwoAndTwoToTheBit) {
  const Settings s = channel();
  const auto mesh = FluidMesh::create(box_mesh({4, 3, 6}, {1, 1, 2}));
  ASSERT_TRUE(mesh.ok());
  const auto steps = [&](FlowSolver& solver, int first, int last) {
    for (int k = first; k < last; ++k) {
      ASSERT_TRUE(
          solver.begin_step({k % 2 == 0 ? Formulation::semi_discrete : Formulation::dsd_sst}, 0.05).ok());
      ASSERT_TRUE(solver.newton(3).ok());
      solver.commit();
    }
  };
  FlowSolver whole(s, *mesh);
  steps(whole, 0, 4);
  FlowSolver half(s, *mesh);
  steps(half, 0, 2);
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "fluid_restart.state";
  ASSERT_TRUE(io::write_state(file, half.export_state()).ok());
  FlowSolver second(s, *mesh);
  const auto state = io::read_state(file);
  ASSERT_TRUE(state.ok());
  ASSERT_TRUE(second.import_state(*state).ok());
  steps(second, 2, 4);
  EXPECT_EQ(second.state().u, whole.state().u);
  EXPECT_EQ(second.state().p, whole.state().p);
  EXPECT_EQ(second.state().time, whole.state().time);
}

TEST(Restart, AStateOfAnotherMeshIsRefused) {
  const Settings s = channel();
  const auto mesh = FluidMesh::create(box_mesh({2, 2, 2}, {1, 1, 2}));
  const auto other = FluidMesh::create(box_mesh({2, 2, 3}, {1, 1, 2}));
  ASSERT_TRUE(mesh.ok() && other.ok());
  FlowSolver solver(s, *other);
  const auto done = solver.import_state(FlowSolver(s, *mesh).export_state());
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().kind, ErrorKind::config);
  EXPECT_NE(done.error().message.find("another mesh"), std::string::npos);
}

/// A coupled channel whose wall at x = 0 moves in, the far side stays.
class CoupledChannel {
 public:
  CoupledChannel() {
    input_.settings = channel();
    input_.settings.interface = {"x0"};
    auto mesh = FluidMesh::create(box_mesh({4, 3, 6}, {1, 1, 2}));
    EXPECT_TRUE(mesh.ok());
    input_.mesh = std::move(*mesh);
    flow_.emplace(input_);
    order({Order::Kind::initialize, {}, {}});
  }
  void order(const Order& order) { EXPECT_TRUE(flow_->execute(order).ok()); }
  void begin(int step) { order({Order::Kind::begin_step, {0.02 * (step - 1), 0.02, 1.0 * step}, {}}); }
  std::vector<double> iterate(double amount) {
    const std::size_t n = 3 * static_cast<std::size_t>(input_.mesh.node_count());
    const std::size_t k = 3 * flow_->interface_file_nodes().size();
    Order iterate{Order::Kind::iterate, std::vector<double>(1 + n + k, 0.0), {}};
    for (std::size_t i = 0; i < n; i += 3) iterate.numbers[1 + i] = amount * (1 - input_.mesh.file.points[i]);
    for (std::size_t i = 0; i < k; i += 3) iterate.numbers[1 + n + i] = amount / 0.02;
    order(iterate);
    return flow_->load().value();
  }

 private:
  Case input_;
  std::optional<CoupledFlow> flow_;
};

/// The participant's promise: the same inputs after rollback give the same loads to the bit.
TEST(CoupledFlow, IteratesAreRepeatableAfterRollback) {
  CoupledChannel flow;
  flow.begin(1);
  const auto first = flow.iterate(0.001);
  const auto second = flow.iterate(0.002);
  EXPECT_NE(first, second);
  flow.order({Order::Kind::rollback, {}, {}});
  flow.begin(1);
  EXPECT_EQ(flow.iterate(0.001), first);
  EXPECT_EQ(flow.iterate(0.002), second);
}

/// And in another process, from a checkpoint; whether one is written changes nothing.
TEST(CoupledFlow, GoesOnFromACheckpointToTheBit) {
  const auto step = [](CoupledChannel& flow, int k) {
    flow.begin(k);
    (void)flow.iterate(0.0008 * k);
    const auto load = flow.iterate(0.001 * k);
    flow.order({Order::Kind::commit, {0.0}, {}});
    return load;
  };
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "coupled_flow_checkpoint";
  std::filesystem::create_directories(folder);
  CoupledChannel whole;
  CoupledChannel first;
  for (const int k : {1, 2}) EXPECT_EQ(step(first, k), step(whole, k));
  first.order({Order::Kind::checkpoint, {}, folder.string()});
  CoupledChannel second;
  second.order({Order::Kind::restore, {}, folder.string()});
  for (const int k : {3, 4}) {
    const auto load = step(whole, k);
    EXPECT_EQ(step(first, k), load);
    EXPECT_EQ(step(second, k), load);
  }
}

TEST(CoupledFlow, AnInvertedMeshIsARetryableError) {
  const Settings s = channel();
  const auto mesh = FluidMesh::create(box_mesh({2, 2, 2}, {1, 1, 1}));
  ASSERT_TRUE(mesh.ok());
  FlowSolver solver(s, *mesh);
  ASSERT_TRUE(solver.begin_step({Formulation::dsd_sst}, 0.1).ok());
  const std::vector<double> zero(mesh->points.size(), 0.0);
  const auto done = solver.set_end(shaken(mesh->points, 0.6, 3), zero, zero);
  ASSERT_FALSE(done.ok());
  EXPECT_TRUE(done.error().retryable);
}

TEST(OpenBoundary, TangentMatchesFiniteDifferences) {
  Settings s = channel();
  s.boundaries[2] = boundary("x0", Condition::traction);
  s.boundaries[2].value = vector_expression("y", "1", "t");
  const auto mesh = FluidMesh::create(box_mesh({2, 2, 2}, {1, 1, 1}));
  ASSERT_TRUE(mesh.ok());
  const la::RowRange own{0, mesh->node_count()};
  const la::LocalPattern pattern = la::local_pattern(mesh->graph, own);
  const OpenBoundary open(s, *mesh, own, pattern);
  StepData data;
  data.dt = 0.1;
  data.x_n = mesh->points;
  data.x_np1 = shaken(mesh->points, 0.05, 2);
  data.unknowns = shaken(std::vector<double>(8 * static_cast<std::size_t>(mesh->node_count()), 0.0), 1, 4);
  const std::vector<double> ones(8, 1.0);
  const std::span<const double, 8> scale(ones.data(), 8);
  const auto evaluate = [&](la::BlockMatrix<8>* jacobian) {
    std::vector<double> r(data.unknowns.size(), 0.0);
    open.add<8>(data, scale, r, jacobian);
    return r;
  };
  la::BlockMatrix<8> jacobian(pattern);
  evaluate(&jacobian);
  const std::vector<double> direction = shaken(std::vector<double>(data.unknowns.size(), 0.0), 1, 9);
  std::vector<double> tangent(data.unknowns.size());
  jacobian.multiply(direction.data(), tangent.data());
  const std::vector<double> base = data.unknowns;
  const double step = 1e-6;
  for (std::size_t i = 0; i < base.size(); ++i) data.unknowns[i] = base[i] + step * direction[i];
  const std::vector<double> plus = evaluate(nullptr);
  for (std::size_t i = 0; i < base.size(); ++i) data.unknowns[i] = base[i] - step * direction[i];
  const std::vector<double> minus = evaluate(nullptr);
  double largest = 0;
  double worst = 0;
  for (std::size_t i = 0; i < base.size(); ++i) {
    worst = std::max(worst, std::abs((plus[i] - minus[i]) / (2 * step) - tangent[i]));
    largest = std::max(largest, std::abs(tangent[i]));
  }
  EXPECT_GT(largest, 1e-4);
  EXPECT_LT(worst, 1e-6 * largest); // the matrix is single precision
}

} // namespace
} // namespace drogue::fluid
