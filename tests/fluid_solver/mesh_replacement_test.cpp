// SPDX-License-Identifier: GPL-3.0-or-later
// A flow that goes over to another mesh of the same domain.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>

#include "common/mesh/msh.hpp"
#include "common/meshing/remesh.hpp"
#include "fluid_solver/coupled_flow.hpp"
#include "fluid_solver/flow_remesher.hpp"
#include "fluid_solver/mesh_transfer.hpp"
#include "fluid_solver/standalone.hpp"
#include "tests/fluid_solver/box.hpp"

namespace drogue::fluid {
namespace {

namespace fs = std::filesystem;
using namespace test;

/// A box, or a rectangle, whose inner nodes were moved at random, and the same boundary filled anew.
struct TwoMeshes {
  explicit TwoMeshes(int dimension = 3) {
    const std::vector<double> size =
        dimension == 2 ? std::vector<double>{1, 2} : std::vector<double>{1, 1, 2};
    mesh::Mesh m = dimension == 2 ? rectangle_mesh({10, 20}, {1, 2}) : box_mesh({5, 5, 8}, {1, 1, 2});
    const std::vector<double> original = m.points;
    m.points = shaken(m.points, dimension == 2 ? 0.02 : 0.04, 7);
    for (std::size_t i = 0; i < m.points.size(); i += 3) {
      bool on_boundary = false;
      for (std::size_t d = 0; d < size.size(); ++d)
        on_boundary = on_boundary || original[i + d] == 0 || original[i + d] == size[d];
      for (std::size_t d = on_boundary ? 0 : size.size(); d < 3; ++d) m.points[i + d] = original[i + d];
    }
    auto filled = meshing::remesh(m);
    EXPECT_TRUE(filled.ok()) << filled.error().message;
    other_file = *filled;
    auto a = FluidMesh::create(std::move(m));
    auto b = FluidMesh::create(std::move(*filled));
    EXPECT_TRUE(a.ok() && b.ok());
    from = std::move(*a);
    to = std::move(*b);
  }
  FluidMesh from, to;
  mesh::Mesh other_file;
};

std::vector<double> at_nodes(const std::vector<double>& x,
                             const std::function<std::array<double, 2>(const double*)>& f) {
  std::vector<double> values;
  for (std::size_t i = 0; i < x.size(); i += 3)
    for (const double value : f(x.data() + i)) values.push_back(value);
  return values;
}

class MeshTransfers : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Dimensions, MeshTransfers, testing::Values(2, 3));

TEST_P(MeshTransfers, ReproduceLinearFields) {
  const TwoMeshes m(GetParam());
  EXPECT_NE(m.from.hash, m.to.hash);
  const auto transfer = MeshTransfer::create(m.from, m.from.points, m.to);
  ASSERT_TRUE(transfer.ok()) << transfer.error().message;
  const auto linear = [](const double* x) -> std::array<double, 2> {
    return {1 + 2 * x[0] - x[1] + 0.5 * x[2], -3 + x[2]};
  };
  const auto exact = at_nodes(m.to.points, linear);
  const auto projected = transfer->projected(at_nodes(m.from.points, linear), 2);
  ASSERT_TRUE(projected.ok()) << projected.error().message;
  const auto interpolated = transfer->interpolated(at_nodes(m.from.points, linear), 2);
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_NEAR((*projected)[i], exact[i], 1e-11);
    EXPECT_NEAR(interpolated[i], exact[i], 1e-12);
  }
}

TEST_P(MeshTransfers, KeepTheBoundaryAndTheIntegral) {
  const TwoMeshes m(GetParam());
  const auto transfer = MeshTransfer::create(m.from, m.from.points, m.to);
  ASSERT_TRUE(transfer.ok());
  const auto wave = [](const double* x) -> std::array<double, 2> {
    return {std::sin(5 * x[0]) * std::cos(3 * x[2]), std::exp(x[1] * x[2])};
  };
  const auto before = at_nodes(m.from.points, wave);
  const auto after = transfer->projected(before, 2);
  ASSERT_TRUE(after.ok());
  const auto I0 = integral(m.from, m.from.points, before, 2), I1 = integral(m.to, m.to.points, *after, 2);
  EXPECT_NEAR(I1[0], I0[0], 1e-13);
  EXPECT_NEAR(I1[1], I0[1], 1e-12);
  const auto exact = at_nodes(m.to.points, wave);
  std::vector<std::int32_t> all(m.to.boundaries.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::int32_t>(i);
  for (const std::int32_t node : m.to.nodes_of(all))
    for (std::size_t k = 0; k < 2; ++k)
      EXPECT_EQ((*after)[2 * static_cast<std::size_t>(node) + k],
                exact[2 * static_cast<std::size_t>(node) + k]);
  double error = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) error = std::max(error, std::abs((*after)[i] - exact[i]));
  EXPECT_LT(error, 0.25); // of values up to 7: what linear elements of this size can do
}

TEST_P(MeshTransfers, RefuseAnotherBoundary) {
  const TwoMeshes m(GetParam());
  std::vector<double> x = m.from.points;
  x[3 * static_cast<std::size_t>(m.from.from_file[0])] += 1e-9;
  EXPECT_FALSE(MeshTransfer::create(m.from, x, m.to).ok());
  const auto space = FluidMesh::create(box_mesh({2, 2, 2}, {1, 1, 2})),
             plane = FluidMesh::create(rectangle_mesh({2, 2}, {1, 2}));
  EXPECT_FALSE(MeshTransfer::create(m.from, m.from.points, *space).ok());
  EXPECT_FALSE(MeshTransfer::create(m.from, m.from.points, *plane).ok());
}

/// Flow along z through a channel with a moving wall, and a probe.
Settings channel() {
  Settings s = tight_settings(0.02);
  s.boundaries = {velocity("z0", "0", "0", "4*x*(1-x)"), boundary("z1", Condition::traction_free),
                  boundary("x0", Condition::no_slip),    boundary("x1", Condition::no_slip),
                  boundary("y0", Condition::free_slip),  boundary("y1", Condition::free_slip)};
  s.initial_velocity = vector_expression("0.2*sin(3*z)*x*(1-x)", "0", "4*x*(1-x)*(1 + 0.3*sin(2*y))");
  s.newton = {1e-9, 30, 0.5, 1, 1};
  s.probes = {{"middle", {0.4, 0.6, 1.1}}};
  s.phases = {{}};
  s.interface = {"x0"};
  return s;
}

/// The same along y in the plane.
Settings plane_channel() {
  Settings s = channel();
  s.boundaries = {velocity("y0", "0", "4*x*(1-x)", "0"), boundary("y1", Condition::traction_free),
                  boundary("x0", Condition::no_slip), boundary("x1", Condition::no_slip)};
  s.initial_velocity = vector_expression("0.2*sin(3*y)*x*(1-x)", "4*x*(1-x)", "0");
  s.probes = {{"middle", {0.4, 1.1, 0}}};
  return s;
}

class Replacement : public testing::Test {
 protected:
  void use_plane() {
    meshes_ = TwoMeshes(2);
    input_.settings = plane_channel();
    input_.mesh = std::move(meshes_.from);
    ASSERT_TRUE(mesh::write_msh(folder_ / "other.msh", meshes_.other_file).ok());
  }
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / fmt::format("fluid_replacement_{}", getpid());
    fs::create_directories(folder_);
    input_.settings = channel();
    input_.mesh = std::move(meshes_.from);
    ASSERT_TRUE(mesh::write_msh(folder_ / "other.msh", meshes_.other_file).ok());
  }
  void TearDown() override { fs::remove_all(folder_); }
  static void step(FlowRun& run) {
    ASSERT_TRUE(run.solver().begin_step({Formulation::dsd_sst}, 0.02).ok());
    const auto done = run.solver().newton(30);
    ASSERT_TRUE(done.ok());
    EXPECT_TRUE(done->converged);
    ASSERT_TRUE(run.finish_step(true).ok());
  }
  /// Largest residual of a continuity row of the last step [volume/time x time].
  static double divergence(const FlowRun& run) {
    const auto residual = run.solver().system().residual();
    const auto width = static_cast<std::size_t>(run.solver().system().unknowns()) / 2;
    double largest = 0;
    for (std::size_t i = width - 1; i < residual.size(); i += width)
      largest = std::max(largest, std::abs(residual[i]));
    return largest;
  }
  void carries_the_flow_over() {
    FlowRun run(input_);
    ASSERT_TRUE(run.open_results(folder_).ok());
    for (int k = 0; k < 3; ++k) step(run);
    const FlowState before = run.solver().state();
    const auto defects = run.replace_mesh(folder_ / "other.msh", meshes_.to.hash, false);
    ASSERT_TRUE(defects.ok()) << defects.error().message;
    const FlowState& after = run.solver().state();
    EXPECT_EQ(after.time, before.time);
    EXPECT_EQ(after.step, before.step);
    EXPECT_EQ(after.x, input_.mesh.points);
    EXPECT_EQ(input_.mesh.hash, meshes_.to.hash);
    // On 250 or 300 nodes, most of which are replaced; the finer the mesh the less.
    EXPECT_LT(defects->mass, 1e-3);
    EXPECT_LT(defects->momentum, 3e-2);
    EXPECT_LT(defects->energy, 5e-2);
    // One solve later the velocity has no divergence, to the solver's tolerance.
    step(run);
    EXPECT_LT(divergence(run), 1e-9);
  }
  /// Alone: a shear that no mesh follows; the mesh is replaced when it must be, and the shear goes on.
  void replaces_a_sheared_mesh(const config::VectorExpression& shear) {
    input_.settings.interface.clear();
    input_.settings.phases = {{.formulation = Formulation::dsd_sst,
                               .step = 0.02,
                               .steps = 8,
                               .mesh_displacement = shear,
                               .time_order = 1,
                               .time_points = 2,
                               .steady_tolerance = 0}};
    input_.settings.remesh = RemeshSettings{.mean_ratio = 0.25, .angle = 0};
    input_.settings.output.directory = folder_ / "alone";
    input_.settings.output.field_interval = 4;
    input_.settings.newton.max_halvings = 0;
    const std::string hash = input_.mesh.hash;
    const auto done = run_standalone(input_);
    ASSERT_TRUE(done.ok()) << done.error().message;
    EXPECT_NE(input_.mesh.hash, hash);
    int files = 0;
    for (const auto& entry : fs::directory_iterator(folder_ / "alone"))
      files += entry.path().extension() == ".msh";
    EXPECT_GE(files, 1);
    EXPECT_GT(smallest_volume_ratio(input_.mesh, input_.mesh.points), 0);
  }

  TwoMeshes meshes_;
  Case input_;
  fs::path folder_;
};

TEST_F(Replacement, CarriesTheFlowOverWithSmallDefects) {
  carries_the_flow_over();
}
TEST_F(Replacement, CarriesAPlaneFlowOverWithSmallDefects) {
  use_plane();
  carries_the_flow_over();
}

TEST_F(Replacement, AnUnknownOrOtherFileIsRefused) {
  FlowRun run(input_);
  EXPECT_FALSE(run.replace_mesh(folder_ / "none.msh", meshes_.to.hash, false).ok());
  const auto other = run.replace_mesh(folder_ / "other.msh", "0123", false);
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.error().kind, ErrorKind::config);
}

/// As a participant: the interface keeps its order, and a run restored on the new mesh goes on to the bit.
TEST_F(Replacement, ARestoredRunGoesOnToTheBit) {
  const auto order = [](CoupledFlow& flow, Order o) {
    const auto done = flow.execute(o);
    EXPECT_TRUE(done.ok()) << done.error().message;
  };
  const auto coupled_step = [&](CoupledFlow& flow, const Case& input, int k) {
    order(flow, {Order::Kind::begin_step, {0.02 * (k - 1), 0.02, 1.0 * k}, {}});
    Order iterate{Order::Kind::iterate,
                  std::vector<double>(1 + 3 * static_cast<std::size_t>(input.mesh.node_count()) +
                                          3 * flow.interface_file_nodes().size(),
                                      0.0),
                  {}};
    for (int i = 0; i < 3; ++i) order(flow, iterate);
    const auto load = flow.load();
    order(flow, {Order::Kind::commit, {1.0}, {}});
    return *load;
  };
  const Order replace{
      Order::Kind::replace_mesh, {0.0}, meshes_.to.hash + "\n" + (folder_ / "other.msh").string()};
  CoupledFlow whole(input_);
  order(whole, {Order::Kind::configure, {0.0}, (folder_ / "whole").string()});
  order(whole, {Order::Kind::initialize, {}, {}});
  Case second_input;
  second_input.settings = input_.settings;
  second_input.mesh = TwoMeshes().from;
  const auto old_nodes = whole.interface_file_nodes();
  std::vector<double> old_points;
  for (const std::int32_t node : old_nodes)
    for (std::size_t d = 0; d < 3; ++d)
      old_points.push_back(input_.mesh.file.points[3 * static_cast<std::size_t>(node) + d]);
  (void)coupled_step(whole, input_, 1);
  order(whole, replace);
  std::vector<double> new_points;
  for (const std::int32_t node : whole.interface_file_nodes())
    for (std::size_t d = 0; d < 3; ++d)
      new_points.push_back(input_.mesh.file.points[3 * static_cast<std::size_t>(node) + d]);
  EXPECT_EQ(old_points, new_points);
  (void)coupled_step(whole, input_, 2);
  fs::create_directories(folder_ / "kept");
  order(whole, {Order::Kind::checkpoint, {}, (folder_ / "kept").string()});

  CoupledFlow second(second_input);
  fs::create_directories(folder_ / "second");
  order(second, {Order::Kind::configure, {0.0}, (folder_ / "second").string()});
  order(second, {Order::Kind::initialize, {}, {}});
  Order restoring = replace;
  restoring.numbers = {1.0};
  order(second, restoring);
  order(second, {Order::Kind::restore, {}, (folder_ / "kept").string()});
  EXPECT_EQ(coupled_step(second, second_input, 3), coupled_step(whole, input_, 3));
  std::ifstream a(folder_ / "whole/probes.csv"), b(folder_ / "second/probes.csv");
  std::string line, last, only;
  while (std::getline(a, line)) last = line;
  while (std::getline(b, line)) only = line;
  EXPECT_EQ(last, only);
}

TEST_F(Replacement, AShearedMeshIsReplacedInAStandAloneRun) {
  replaces_a_sheared_mesh(vector_expression("0", "0", "60*t*x*(1-x)*y*(1-y)*z*(2-z)"));
}
TEST_F(Replacement, AShearedPlaneMeshIsReplacedInAStandAloneRun) {
  use_plane();
  replaces_a_sheared_mesh(vector_expression("0", "20*t*x*(1-x)*y*(2-y)*(x-0.5)*3", "0"));
}

} // namespace
} // namespace drogue::fluid
