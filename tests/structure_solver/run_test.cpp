// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whole runs through files: restart, static equilibrium, results, the participant's promises, what `check`
// reports.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "common/io/state_file.hpp"
#include "common/mesh/msh.hpp"
#include "structure_solver/coupled.hpp"
#include "structure_solver/run.hpp"
#include "structure_solver/state_io.hpp"
#include "tests/structure_solver/test_structures.hpp"
#include "tests/support/signalled.hpp"

namespace drogue::structure {
namespace {

namespace fs = std::filesystem;
using test::Numbers;

constexpr const char* properties = R"(
  mesh: "cloth.msh"
  membrane { group: "cloth" thickness: 0.01 density: 6 youngs_modulus: 2e5 }
  cable { group: "hem" area: 1e-3 density: 6 youngs_modulus: 4e6 }
  support { group: "edge" }
  gravity { z: "-9.81" }
)";

/// A Q9 sheet held at its edge with a cable across, in a folder of its own that is the working directory.
class Files : public testing::Test {
 protected:
  void SetUp() override {
    previous_ = fs::current_path();
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / fmt::format("drogue-structure-{}-{}", info->name(), getpid());
    fs::create_directories(folder_);
    fs::current_path(folder_);
    mesh::Mesh mesh = test::sheet(mesh::ElementKind::quad9, 2, 2,
                                  [](double s, double t) { return Eigen::Vector3d(s, t, 0); });
    mesh.blocks.push_back({"hem", mesh::ElementKind::line2, {10, 11, 11, 12, 12, 13, 13, 14}});
    mesh.node_fields["material"] = {3, mesh.points};
    const auto written = mesh::write_msh("cloth.msh", mesh);
    ASSERT_TRUE(written) << written.error().message;
  }
  void TearDown() override {
    fs::current_path(previous_);
    fs::remove_all(folder_);
  }
  static void write(const std::string& name, const std::string& text) { std::ofstream(name) << text; }
  static std::string read(const std::string& name) {
    std::ifstream stream(name, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }
  static Case load(const std::string& name) {
    auto c = load_case(name);
    EXPECT_TRUE(c) << (c ? "" : c.error().message);
    return c ? std::move(*c) : Case{};
  }

 private:
  fs::path previous_, folder_;
};

TEST_F(Files, HalfARunTwiceIsTheWholeRunToTheBit) {
  const auto config = [](int steps, const std::string& more) {
    return fmt::format(
        "{} pressure {{ group: \"cloth\" value: \"40*sin(30*t)\" }} time {{ step: 0.01 steps: {} }} {}",
        properties, steps, more);
  };
  write("whole.textproto", config(8, "final_state: \"whole.state\""));
  write("first.textproto", config(4, "final_state: \"half.state\""));
  write("second.textproto", config(4, "initial_state: \"half.state\" final_state: \"twice.state\""));
  ASSERT_TRUE(run_file("whole.textproto"));
  ASSERT_TRUE(run_file("first.textproto"));
  ASSERT_TRUE(run_file("second.textproto"));
  const std::string whole = read("whole.state");
  EXPECT_GT(whole.size(), 25U * 3 * 3 * 8);
  EXPECT_EQ(whole, read("twice.state"));
  EXPECT_NE(whole, read("half.state"));
}

/// What a run carries besides displacement and rates survives a restart too: a hem that is drawn in, a moving
/// edge, dampings, drag, the account of energy, and a step that Newton has halved.
TEST_F(Files, RestartAmidHalvedStepsAndMovingLengthsIsTheSameToTheBit) {
  const auto config = [](int steps, const std::string& more) {
    return fmt::format(R"(
      mesh: "cloth.msh"
      membrane {{ group: "cloth" thickness: 0.01 density: 6 youngs_modulus: 2e5 }}
      cable {{ group: "hem" area: 1e-3 density: 6 youngs_modulus: 4e6 slack_strain: 1e-3 }}
      natural_length {{ group: "hem" point {{ time: 0.01 factor: 1 }} point {{ time: 0.2 factor: 0.7 }} }}
      support {{ group: "edge" displacement {{ z: "sin(20*t)/10" }} }}
      line_drag {{ group: "hem" drag_coefficient: 1 diameter: 0.03 air_density: 1.2 air_velocity {{ z: "5" }} }}
      pressure {{ group: "cloth" value: "400*t" }}
      newton {{ max_iterations: 4 displacement_tolerance: 1e-9 residual_tolerance: 1e-12 }}
      time {{ step: 0.04 steps: {} scheme: HHT hht_alpha: -0.1 mass_damping: 0.5 stiffness_damping: 1e-4 }} {})",
                       steps, more);
  };
  write("whole.textproto", config(6, "final_state: \"whole.state\" output { directory: \"whole\" }"));
  write("first.textproto", config(3, "final_state: \"half.state\" output { directory: \"halves\" }"));
  write(
      "second.textproto",
      config(3,
             "initial_state: \"half.state\" final_state: \"twice.state\" output { directory: \"halves\" }"));
  for (const char* name : {"whole.textproto", "first.textproto", "second.textproto"}) {
    const auto done = run_file(name);
    ASSERT_TRUE(done) << name << ": " << done.error().message;
  }
  const Case c = load("whole.textproto");
  const auto half = read_state("half.state", *c.model);
  ASSERT_TRUE(half);
  EXPECT_GT(half->halvings, 0) << "the case is too easy: no step was halved";
  EXPECT_EQ(read("whole.state"), read("twice.state"));
  const auto last_line = [](const std::string& text) {
    return text.substr(text.rfind('\n', text.size() - 2));
  };
  EXPECT_EQ(last_line(read("whole/structure.csv")), last_line(read("halves/structure_from_4.csv")));
}

TEST_F(Files, DivergenceNamesNodesKeepsTheLastGoodStateAndIsANumericalError) {
  write("diverge.textproto", std::string(properties) + R"(
    pressure { group: "cloth" value: "1e9*t*t" }
    newton { max_iterations: 3 }
    time { step: 0.01 steps: 10 max_halvings: 2 }
    output { directory: "out" }
  )");
  const auto done = run_file("diverge.textproto");
  ASSERT_FALSE(done);
  EXPECT_EQ(exit_status(done.error()), 3);
  const std::string& text = done.error().message;
  EXPECT_NE(text.find("of \"cloth\""), std::string::npos) << text;
  EXPECT_NE(text.find("last_good.state"), std::string::npos) << text;
  const Case c = load("diverge.textproto");
  const auto state = read_state("out/last_good.state", *c.model);
  ASSERT_TRUE(state) << state.error().message;
  EXPECT_TRUE(std::all_of(state->u.begin(), state->u.end(), [](double u) { return std::isfinite(u); }));
  EXPECT_TRUE(fs::exists("out/structure.pvd"));
}

/// Newton's statics and damped dynamics find the same equilibrium of a prestressed sheet.
TEST_F(Files, BothStaticsAgree) {
  const std::string sheet = R"(
    mesh: "cloth.msh" ignore_group: "hem"
    membrane { group: "cloth" thickness: 0.01 density: 6 youngs_modulus: 2e5 prestress: 1000 }
    support { group: "edge" }
    pressure { group: "cloth" value: "60" }
    newton { load_stiffness: true displacement_tolerance: 1e-10 }
    output { field_interval: 0 }
  )";
  write("newton.textproto",
        sheet + "final_state: \"newton.state\" time { mode: STATIC_BY_NEWTON step: 0.25 steps: 4 }");
  write("damped.textproto", sheet + R"(final_state: "damped.state"
    time { mode: STATIC_BY_DAMPED_DYNAMICS step: 0.05 largest_step: 1 rho_infinity: 0 mass_damping: 20 unbalance: 1e-9 })");
  for (const char* name : {"newton.textproto", "damped.textproto"}) {
    const auto done = run_file(name);
    ASSERT_TRUE(done) << name << ": " << done.error().message;
  }
  const Case c = load("newton.textproto");
  const auto a = read_state("newton.state", *c.model), b = read_state("damped.state", *c.model);
  ASSERT_TRUE(a && b);
  EXPECT_GT(a->u[3 * 12 + 2], 0.05);
  for (std::size_t i = 0; i < a->u.size(); ++i) EXPECT_NEAR(a->u[i], b->u[i], 1e-8);
}

TEST_F(Files, MechanismIsRefused) {
  write("flat.textproto",
        std::string(properties) + "time { mode: STATIC_BY_NEWTON } output { field_interval: 0 }");
  const auto done = run_file("flat.textproto");
  ASSERT_FALSE(done);
  EXPECT_EQ(exit_status(done.error()), 2);
  EXPECT_NE(done.error().message.find("of \"cloth\""), std::string::npos) << done.error().message;
}

TEST_F(Files, CheckRefusesWhatOnlyTheStartTells) {
  write("wrong.textproto", R"(mesh: "cloth.msh"
membrane { group: "cloth" thickness: 0.01 density: 6 youngs_modulus: 2e5 }
cable { group: "hem" area: 1e-3 density: 6 youngs_modulus: 4e6 }
support { group: "edge" }
pressure { group: "cloth" value: "1/(x-x)+0" }
force { group: "hem" value { z: "sqrt(t-1)+0" } }
probe { name: "far" x: 5 y: 0.5 z: 0 }
natural_length { group: "hem" factor: "t" }
)");
  const auto checked = check_case("wrong.textproto");
  ASSERT_FALSE(checked);
  const std::string& text = checked.error().message;
  EXPECT_NE(text.find("wrong.textproto:5:"), std::string::npos) << text;
  EXPECT_NE(text.find("pressure on group \"cloth\", \"1/(x-x)+0\""), std::string::npos) << text;
  EXPECT_NE(text.find("force on group \"hem\""), std::string::npos) << text;
  EXPECT_NE(text.find("probe \"far\" at (5, 0.5, 0) is 4 away"), std::string::npos) << text;
  EXPECT_NE(text.find("natural length of group \"hem\""), std::string::npos) << text;
}

TEST_F(Files, CheckRefusesContradictoryRolesAndUnknownGroupsEverywhere) {
  write("wrong.textproto", std::string(properties) + R"(
truss { group: "hem" area: 1e-3 density: 6 youngs_modulus: 4e6 }
ignore_group: "cloth"
point_drag { group: "edg" drag_coefficient: 1 area: 1 air_density: 1.2 }
line_drag { group: "cloth" drag_coefficient: 1 diameter: 0.1 air_density: 1.2 }
natural_length { group: "hen" }
)");
  const auto checked = check_case("wrong.textproto");
  ASSERT_FALSE(checked);
  const std::string& text = checked.error().message;
  EXPECT_NE(text.find("group \"hem\" is named here and in cable[0].group"), std::string::npos) << text;
  EXPECT_NE(text.find("group \"cloth\" is named here and in membrane[0].group"), std::string::npos) << text;
  EXPECT_NE(text.find("did you mean \"edge\""), std::string::npos) << text;
  EXPECT_NE(text.find("did you mean \"hem\""), std::string::npos) << text;
  EXPECT_NE(text.find("group \"cloth\" is not a cable or truss"), std::string::npos) << text;
}

TEST_F(Files, StaticRunStopsInEquilibriumAndWritesResults) {
  write("static.textproto", std::string(properties) + R"(
    pressure { group: "cloth" value: "40" }
    time { mode: STATIC_BY_DAMPED_DYNAMICS step: 0.01 largest_step: 1 rho_infinity: 0 mass_damping: 20 unbalance: 1e-4 }
    final_state: "static.state"
    output { directory: "out" field_interval: 5 }
    probe { name: "centre" x: 0.5 y: 0.5 z: 0 }
  )");
  const auto done = run_file("static.textproto");
  ASSERT_TRUE(done) << done.error().message;
  const Case c = load("static.textproto");
  const auto state = read_state("static.state", *c.model);
  ASSERT_TRUE(state) << state.error().message;
  Integrator integrator(*c.model, c.integrator_options(), *state);
  EXPECT_LT(integrator.balance().unbalance, 1e-4);
  EXPECT_GT(state->u[3 * 12 + 2], 0.01);
  EXPECT_TRUE(fs::exists("out/structure.pvd"));

  // the last row of probes.csv is the centre node's displacement, velocity and acceleration
  std::istringstream probes(read("out/probes.csv"));
  std::string header, row, cell;
  std::getline(probes, header);
  EXPECT_EQ(header.rfind("time,centre_x,centre_y,centre_z,centre_velocity_x", 0), 0U) << header;
  for (std::string line; std::getline(probes, line);) row = line;
  std::vector<double> values;
  for (std::istringstream cells(row); std::getline(cells, cell, ',');) values.push_back(std::stod(cell));
  ASSERT_EQ(values.size(), 10U);
  EXPECT_DOUBLE_EQ(values[3], state->u[3 * 12 + 2]);
  EXPECT_DOUBLE_EQ(values[6], state->v[3 * 12 + 2]);
  EXPECT_DOUBLE_EQ(values[9], state->a[3 * 12 + 2]);

  // reactions balance weight and pressure: read the last row of structure.csv by its header
  const std::string series = read("out/structure.csv");
  EXPECT_NE(series.find("reaction_edge_z"), std::string::npos);
}

TEST_F(Files, StaticRunThatCannotBalanceIsANumericalError) {
  write("short.textproto", std::string(properties) + R"(
    pressure { group: "cloth" value: "40" }
    time { mode: STATIC_BY_DAMPED_DYNAMICS step: 0.01 largest_time: 0.02 mass_damping: 20 }
  )");
  const auto done = run_file("short.textproto");
  ASSERT_FALSE(done);
  EXPECT_EQ(exit_status(done.error()), 3);
}

TEST_F(Files, CheckReportsEveryMismatchWithTheMesh) {
  write("wrong.textproto", R"(mesh: "cloth.msh"
membrane { group: "cloths" thickness: 0.01 density: 6 youngs_modulus: 2e5 }
cable { group: "cloth" area: 1e-3 density: 6 youngs_modulus: 4e6 }
support { group: "edge" components: "xw" }
interface: "hem"
)");
  const auto checked = check_case("wrong.textproto");
  ASSERT_FALSE(checked);
  EXPECT_EQ(exit_status(checked.error()), 2);
  const std::string& text = checked.error().message;
  EXPECT_NE(text.find("wrong.textproto:2:"), std::string::npos) << text;
  EXPECT_NE(text.find("did you mean \"cloth\""), std::string::npos) << text;
  EXPECT_NE(text.find("2-node line elements are needed here"), std::string::npos) << text;
  EXPECT_NE(text.find("only the letters x, y and z"), std::string::npos) << text;
  EXPECT_NE(text.find("group \"hem\" holds 2-node line elements; 3-node triangle"), std::string::npos)
      << text;

  write("unused.textproto", R"(mesh: "cloth.msh"
membrane { group: "cloth" thickness: 0.01 density: 6 youngs_modulus: 2e5 }
)");
  const auto unused = check_case("unused.textproto");
  ASSERT_FALSE(unused);
  EXPECT_NE(unused.error().message.find("group \"hem\" of cloth.msh has no role"), std::string::npos);
}

TEST_F(Files, CheckRefusesAStateOfAnotherMesh) {
  io::State state{"structure", "0123456789abcdef", 0, 0, {}};
  ASSERT_TRUE(io::write_state("other.state", state));
  write("config.textproto", std::string(properties) + "initial_state: \"other.state\"");
  const auto checked = check_case("config.textproto");
  ASSERT_FALSE(checked);
  EXPECT_NE(checked.error().message.find("another mesh"), std::string::npos) << checked.error().message;
}

/// Drives a participant as the coupler does.
class CoupledRun : public Files {
 protected:
  void SetUp() override {
    Files::SetUp();
    write("coupled.textproto", std::string(properties) + R"(
      interface: "cloth"
      newton { iterations_per_coupling: 1 }
      output { directory: "out" field_interval: 0 }
    )");
  }
  static std::unique_ptr<Coupled> start() {
    auto solver = std::make_unique<Coupled>(load("coupled.textproto"));
    EXPECT_TRUE(solver->configure({fs::current_path() / "run", 0, 0.01}));
    EXPECT_TRUE(solver->initialize());
    return solver;
  }
  static participant::Fields inputs(std::uint64_t seed, const std::vector<double>& d) {
    participant::Fields in;
    std::vector<double> force(75);
    Numbers numbers;
    for (double& f : force) f = 0.05 * numbers() * static_cast<double>(seed);
    in["force"] = {{25, 3}, force};
    in["displacement"] = {{25, 3}, d};
    return in;
  }
  /// One step of `iterations` plain fixed-point iterations; returns the last outputs.
  static participant::Fields step(Coupled& solver, std::uint64_t k, std::vector<double>& d,
                                  int iterations = 3) {
    participant::Fields out;
    EXPECT_TRUE(solver.begin_step({k, 1, 0.01 * static_cast<double>(k - 1), 0.01}));
    for (int i = 0; i < iterations; ++i) {
      EXPECT_TRUE(solver.iterate(inputs(k, d), out));
      d = out.at("displacement").values;
    }
    return out;
  }
};

TEST_F(CoupledRun, InterfaceIsTheMembrane) {
  Coupled solver(load("coupled.textproto"));
  ASSERT_TRUE(solver.configure({fs::current_path(), 0, 0.01}));
  const auto mesh = solver.initialize();
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->points.size(), 75U);
  EXPECT_EQ(mesh->quadrangles9.size(), 4U * 9);
  EXPECT_TRUE(mesh->triangles.empty());
  EXPECT_EQ(mesh->material, mesh->reference);
  EXPECT_EQ(mesh->mesh_nodes.size(), 25U);
}

/// A plane strip of solid elements and a cable along its lower edge, either of them wetted.
TEST_F(CoupledRun, InAPlaneProblemTheInterfaceIsMadeOfLines) {
  mesh::Mesh mesh = test::sheet(mesh::ElementKind::quad9, 2, 1,
                                [](double s, double t) { return Eigen::Vector3d(2 * s, 0.5 * t, 0); });
  mesh.blocks.push_back({"wall", mesh::ElementKind::line3, {0, 2, 1, 2, 4, 3}});
  mesh.blocks.push_back({"cable", mesh::ElementKind::line2, {0, 1, 1, 2, 2, 3, 3, 4}});
  ASSERT_TRUE(mesh::write_msh("strip.msh", mesh));
  const auto config = [](const std::string& interface) {
    return "mesh: \"strip.msh\" plane: true solid { group: \"cloth\" density: 1 youngs_modulus: 1000 "
           "poisson_ratio: 0.3 } "
           "cable { group: \"cable\" area: 1e-6 density: 1 youngs_modulus: 1 } ignore_group: \"edge\" "
           "ignore_group: \"wall\" "
           "newton { displacement_tolerance: 1e-12 } output { directory: \"out\" field_interval: 0 } "
           "interface: \"" +
           interface + "\"";
  };
  for (const std::string group : {"wall", "cable"}) {
    write("coupled.textproto", config(group));
    Coupled solver(load("coupled.textproto"));
    ASSERT_TRUE(solver.configure({fs::current_path() / "run", 0, 0.01}));
    const auto interface = solver.initialize();
    ASSERT_TRUE(interface);
    EXPECT_EQ(interface->points.size(), 15U);
    EXPECT_EQ(interface->lines3.size(), group == "wall" ? 6U : 0U);
    EXPECT_EQ(interface->lines.size(), group == "wall" ? 0U : 8U);
    const std::vector<double> each{1. / 6, 2. / 3, 1. / 3, 2. / 3, 1. / 6};
    participant::Fields in, out;
    in["displacement"] = {{5, 3}, std::vector<double>(15, 0.0)};
    in["force"] = {{5, 3}, std::vector<double>(15, 0.0)};
    for (std::size_t i = 0; i < 5; ++i) in["force"].values[3 * i + 1] = each[i];
    ASSERT_TRUE(solver.begin_step({1, 1, 0, 0.01}));
    const auto report = solver.iterate(in, out);
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_TRUE(solver.commit(false));
    const auto& d = out.at("displacement").values;
    const auto& v = out.at("velocity").values;
    for (std::size_t i = 0; i < 5; ++i) { // a symmetric load on a symmetric body
      EXPECT_EQ(d[3 * i + 2], 0);
      EXPECT_GT(d[3 * i + 1], 1e-6);
      EXPECT_NEAR(d[3 * i], -d[3 * (4 - i)], 1e-12);
      EXPECT_NEAR(d[3 * i + 1], d[3 * (4 - i) + 1], 1e-12);
      EXPECT_NEAR(v[3 * i + 1], v[3 * (4 - i) + 1], 1e-10);
    }
    EXPECT_GT(v[1], 1e-3);
  }
  write("coupled.textproto", config("cloth"));
  const auto refused = load_case("coupled.textproto");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("2-node line or 3-node line elements are needed here"),
            std::string::npos)
      << refused.error().message;
}

TEST_F(CoupledRun, RollbackAndRepeatGiveTheSameBits) {
  auto solver = start();
  std::vector<double> d(75, 0.0);
  (void)step(*solver, 1, d);
  ASSERT_TRUE(solver->commit(false));
  std::vector<double> first = d, second = d, other = d;
  const auto a = step(*solver, 2, first);
  ASSERT_TRUE(solver->rollback());
  (void)step(*solver, 7, other, 5); // another attempt leaves no trace
  ASSERT_TRUE(solver->rollback());
  const auto b = step(*solver, 2, second);
  EXPECT_EQ(a.at("displacement").values, b.at("displacement").values);
  EXPECT_EQ(a.at("velocity").values, b.at("velocity").values);
  EXPECT_NE(first, other);
}

TEST_F(CoupledRun, CheckpointAndRestoreContinueToTheBit) {
  auto solver = start();
  std::vector<double> d(75, 0.0);
  for (std::uint64_t k = 1; k <= 2; ++k) {
    (void)step(*solver, k, d);
    ASSERT_TRUE(solver->commit(true));
  }
  ASSERT_TRUE(solver->checkpoint(fs::current_path()));
  std::vector<double> resumed = d;
  (void)step(*solver, 3, d);

  auto again = start();
  ASSERT_TRUE(again->restore(fs::current_path()));
  (void)step(*again, 3, resumed);
  EXPECT_EQ(d, resumed);
  EXPECT_TRUE(fs::exists("run/structure.csv"));
}

TEST_F(CoupledRun, StepsCountAsTheCouplersDoAndTheLastFieldsAreWritten) {
  write("coupled.textproto", std::string(properties) + "interface: \"cloth\" output { field_interval: 100 }");
  auto solver = start();
  std::vector<double> d(75, 0.0);
  (void)step(*solver, 1, d);
  ASSERT_TRUE(solver->commit(true));
  (void)step(*solver, 2, d);
  ASSERT_TRUE(solver->rollback()); // RETRY
  (void)step(*solver, 2, d);
  ASSERT_TRUE(solver->commit(true));
  EXPECT_FALSE(fs::exists("run/structure_000002.vtu"));
  ASSERT_TRUE(solver->finish());
  EXPECT_TRUE(fs::exists("run/structure_000002.vtu"));
  const std::string series = read("run/structure.csv");
  const std::string last = series.substr(series.rfind('\n', series.size() - 2) + 1);
  EXPECT_EQ(last.substr(last.find(','), 3), ",2,");
}

/// A hem that is drawn in lifts the cloth in a coupled run as well.
TEST_F(CoupledRun, NaturalLengthsFollowTheCouplersClock) {
  write("coupled.textproto",
        std::string(properties) +
            "interface: \"cloth\" natural_length { group: \"hem\" factor: \"1 - 5*t\" }");
  auto solver = start();
  std::vector<double> d(75, 0.0);
  for (std::uint64_t k = 1; k <= 2; ++k) {
    (void)step(*solver, k, d, 1);
    ASSERT_TRUE(solver->commit(true));
  }
  const std::string series = read("run/structure.csv");
  EXPECT_NE(series.find("actuator_work"), std::string::npos);
  std::istringstream lines(series);
  std::string header, row, name, cell;
  std::getline(lines, header);
  for (std::string line; std::getline(lines, line);) row = line;
  std::istringstream names(header), cells(row);
  double work = 0;
  while (std::getline(names, name, ',') && std::getline(cells, cell, ','))
    if (name == "actuator_work") work = std::stod(cell);
  EXPECT_GT(work, 0);
}

TEST_F(CoupledRun, OneNewtonStepAnIterateConvergesToTheStepsSolution) {
  auto solver = start();
  std::vector<double> d(75, 0.0), exact(75, 0.0);
  (void)step(*solver, 1, d, 12);
  write("coupled.textproto",
        std::string(properties) + "interface: \"cloth\" newton { displacement_tolerance: 1e-12 }");
  auto full = start();
  (void)step(*full, 1, exact, 1);
  for (std::size_t i = 0; i < d.size(); ++i) EXPECT_NEAR(d[i], exact[i], 1e-9);
}

TEST_F(CoupledRun, NeedsAnInterface) {
  write("coupled.textproto", properties);
  const auto loaded = load_case("coupled.textproto", Role::participant);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().kind, ErrorKind::config);
  EXPECT_NE(loaded.error().message.find("a participant needs interface"), std::string::npos);
}

TEST_F(Files, ASignalEndsTheProgramAfterTheStepWithItsState) {
  write("long.textproto", std::string(properties) +
                              "time { step: 0.001 steps: 1000000 } final_state: \"last.state\" output { "
                              "field_interval: 0 }");
  const int status = std::system((drogue::test::signalled("TERM", "step ") +
                                  "'" DROGUE_BIN_DIR "/structure_solver' run long.textproto > log 2>&1")
                                     .c_str());
  EXPECT_EQ(WEXITSTATUS(status), 5) << read("log");
  EXPECT_NE(read("log").find("interrupted after step "), std::string::npos) << read("log");
  EXPECT_TRUE(fs::exists("last.state"));
}

} // namespace
} // namespace drogue::structure
