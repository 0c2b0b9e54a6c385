// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <sys/wait.h>

#include "common/io/state_file.hpp"
#include "common/mesh/msh.hpp"
#include "tests/fluid_solver/box.hpp"
#include "tests/support/signalled.hpp"

/// Runs the program itself: command line, files, exit status, ranks.
namespace drogue::fluid {
namespace {

namespace fs = std::filesystem;

constexpr const char* base_config = R"config(
mesh: "box.msh"
final_state: "FINAL"
density: 2
dynamic_viscosity: 0.02
smagorinsky: 0.1
initial_velocity { z: "1" }
phase { formulation: SEMI_DISCRETE step: 0.05 steps: 2 }
phase { formulation: DSD_SST step: 0.02 steps: 2 mesh_displacement { x: "0.05*(1-x)*sin(t)*z*(2-z)" } }
newton { residual_tolerance: 1e-9 max_iterations: 12 }
linear { tolerance: 1e-4 }
boundary { name: "z0" velocity { z: "1" } }
boundary { name: "z1" traction_free {} }
boundary { name: "x0" no_slip {} }
boundary { name: "x1" free_slip {} }
boundary { name: "y0" free_slip {} }
boundary { name: "y1" free_slip {} }
force { name: "wall" boundary: "x0" reference_area: 2 reference_speed: 1 }
probe { name: "middle" x: 0.5 y: 0.5 z: 1 }
output { directory: "OUT" field_interval: 2 }
)config";

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), with);
}

std::string read(const fs::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

class FluidProgram : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              (std::string("fluid_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    ASSERT_TRUE(mesh::write_msh(folder_ / "box.msh", test::box_mesh({4, 3, 6}, {1, 1, 2})).ok());
  }

  /// Exit status of the command; standard error lands in log().
  int run(const std::string& prefix, const std::string& arguments, const std::string& text) {
    std::ofstream(folder_ / "case.textproto") << text;
    const std::string command = "cd '" + folder_.string() + "' && " + prefix +
                                " '" DROGUE_BIN_DIR "/fluid_solver' " + arguments +
                                " case.textproto > log 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  }
  [[nodiscard]] std::string log() const { return read(folder_ / "log"); }

  fs::path folder_;
};

/// The command for a number of ranks.
std::string ranks(int n) {
  return n == 1 ? "" : "mpiexec --oversubscribe -n " + std::to_string(n);
}

/// One of the slip walls is curved, the mesh moves.
TEST_F(FluidProgram, TwoAndThreeRanksGiveWhatOneGives) {
  mesh::Mesh bulged = test::box_mesh({4, 3, 6}, {1, 1, 2});
  for (std::size_t i = 0; i < bulged.points.size(); i += 3)
    bulged.points[i + 1] *= 1 + 0.15 * std::sin(1.5 * bulged.points[i + 2]);
  ASSERT_TRUE(mesh::write_msh(folder_ / "box.msh", bulged).ok());
  for (const int n : {1, 2, 3}) {
    const std::string name = std::to_string(n);
    const std::string text = replaced(base_config, "OUT", "out" + name);
    ASSERT_EQ(run(ranks(n), "run", replaced(text, "FINAL", name + ".state")), 0) << log();
  }
  const auto one = io::read_state(folder_ / "1.state");
  ASSERT_TRUE(one.ok());
  EXPECT_NEAR(one->time, 0.14, 1e-12);
  EXPECT_EQ(one->step, 4U);
  for (const char* file : {"2.state", "3.state"}) {
    const auto other = io::read_state(folder_ / file);
    ASSERT_TRUE(other.ok());
    for (const char* name : {"velocity", "pressure"}) {
      const auto& a = one->find(name)->values;
      const auto& b = other->find(name)->values;
      ASSERT_EQ(a.size(), b.size());
      double size = 0;
      for (const double value : a) size = std::max(size, std::abs(value));
      for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-6 * size) << name << " " << file;
    }
  }
  EXPECT_TRUE(fs::exists(folder_ / "out3/piece_000004_2.vtu"));
  EXPECT_NE(read(folder_ / "out3/fluid.pvd").find("fluid_000004.pvtu"), std::string::npos);
  const std::string same = DROGUE_PYTHON " " DROGUE_SOURCE_DIR "/tests/fluid_solver/same_fields.py ";
  for (const char* out : {"out2", "out3"})
    EXPECT_EQ(std::system((same + (folder_ / "out1/fluid_000004.vtu ").string() +
                           (folder_ / out / "fluid_000004.pvtu").string())
                              .c_str()),
              0);
}

/// A uniform flow along a channel oblique to all axes, first on a fixed, then on a moving mesh.
TEST_F(FluidProgram, AUniformFlowBetweenObliqueSlipWallsStaysUniformOnAnyNumberOfRanks) {
  mesh::Mesh m = test::box_mesh({3, 3, 6}, {1, 1, 2});
  for (std::size_t i = 0; i < m.points.size(); i += 3) {
    const double x = m.points[i];
    const double y = m.points[i + 1];
    const double z = m.points[i + 2];
    m.points[i] = (2 * x - y + 2 * z) / 3;
    m.points[i + 1] = (2 * x + 2 * y - z) / 3;
    m.points[i + 2] = (-x + 2 * y + 2 * z) / 3;
  }
  ASSERT_TRUE(mesh::write_msh(folder_ / "box.msh", m).ok());
  std::string text = replaced(base_config, "{ z: \"1\" }", "{ x: \"1\" y: \"-0.5\" z: \"1\" }");
  text = replaced(text, "velocity { z: \"1\" }", "velocity { x: \"1\" y: \"-0.5\" z: \"1\" }");
  text = replaced(text, "name: \"x0\" no_slip", "name: \"x0\" free_slip");
  text = replaced(text, "0.05*(1-x)*sin(t)*z*(2-z)\"",
                  "0.2*sin(3*y)*sin(t-0.1)\" y: \"-0.1*sin(3*y)*sin(t-0.1)\" z: \"0.2*sin(3*y)*sin(t-0.1)\"");
  text = replaced(replaced(text, "1e-9", "1e-12"), "1e-4", "1e-6");
  text = replaced(text, "x: 0.5 y: 0.5 z: 1", "x: 0.8 y: 0.4 z: 0.9");
  for (const int n : {1, 2, 3}) {
    ASSERT_EQ(run(ranks(n), "run", replaced(text, "FINAL", "end.state")), 0) << log();
    const auto end = io::read_state(folder_ / "end.state");
    ASSERT_TRUE(end.ok());
    const auto& u = end->find("velocity")->values;
    const double exact[3] = {1, -0.5, 1};
    for (std::size_t i = 0; i < u.size(); ++i) EXPECT_NEAR(u[i], exact[i % 3], 1e-10);
  }
}

TEST_F(FluidProgram, WritesSeriesAndFields) {
  ASSERT_EQ(run("", "run", replaced(replaced(base_config, "OUT", "out"), "FINAL", "end.state")), 0) << log();
  for (const char* name : {"flow.csv", "forces.csv", "probes.csv"}) {
    const std::string text = read(folder_ / "out" / name);
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 5) << name; // header and four steps
  }
  EXPECT_NE(read(folder_ / "out/forces.csv").find("wall_coefficient_x"), std::string::npos);
  EXPECT_TRUE(fs::exists(folder_ / "out/fluid.pvd"));
  EXPECT_TRUE(fs::exists(folder_ / "out/fluid_000004.vtu"));
}

TEST_F(FluidProgram, CheckReportsEveryErrorAtOnce) {
  std::string text = replaced(base_config, "density: 2", "density: -2");
  text = replaced(text, "name: \"z0\"", "name: \"z00\"");
  text = replaced(text, "boundary: \"x0\"", "boundary: \"wall\"");
  text = replaced(text, "reference_speed: 1 ", "");
  text = replaced(text, "SEMI_DISCRETE step: 0.05 steps: 2",
                  "SEMI_DISCRETE step: 0.05 steps: 2 mesh_displacement { x: \"t\" }");
  EXPECT_EQ(run("", "check", text), 2);
  const std::string errors = log();
  for (const char* part :
       {"case.textproto:4:", "\"z00\"", "did you mean", "no boundary named \"wall\"", "has no condition",
        "reference_speed", "mesh_displacement needs formulation: DSD_SST"})
    EXPECT_NE(errors.find(part), std::string::npos) << part << "\n" << errors;
}

TEST_F(FluidProgram, CheckAcceptsAGoodConfig) {
  EXPECT_EQ(run("", "check", base_config), 0) << log();
  EXPECT_NE(log().find("case.textproto: ok"), std::string::npos);
}

TEST_F(FluidProgram, AProbeOutsideAndAFeatureAngleOutOfRangeAreRefused) {
  EXPECT_EQ(run("", "check", replaced(base_config, "z: 1 }\noutput", "z: 7 }\noutput")), 2);
  EXPECT_NE(log().find("lies outside the fluid"), std::string::npos) << log();
  EXPECT_EQ(run("", "check", replaced(base_config, "density: 2", "density: 2 slip_feature_angle: 120")), 2);
  EXPECT_NE(log().find("slip_feature_angle"), std::string::npos) << log();
}

/// The third step, a billion times longer, cannot reach the tolerance in two iterations: what the second one
/// left stays, in fields, series and state.
TEST_F(FluidProgram, AStepThatFailsKeepsTheLastGoodState) {
  std::string text =
      replaced(base_config, "steps: 2 }", "steps: 2 }\nphase { formulation: DSD_SST step: 1e9 steps: 1 }");
  text = replaced(text, "max_iterations: 12", "max_iterations: 2 failure_tolerance: 7e-4");
  EXPECT_EQ(run("", "run", replaced(replaced(text, "OUT", "out"), "FINAL", "last.state")), 3) << log();
  for (const char* part : {"step 3 to t = 1e+09 failed", "the worst was", "after step 2", "last.state"})
    EXPECT_NE(log().find(part), std::string::npos) << part << "\n" << log();
  const auto last = io::read_state(folder_ / "last.state");
  ASSERT_TRUE(last.ok());
  EXPECT_EQ(last->step, 2U);
  EXPECT_NEAR(last->time, 0.1, 1e-12);
  const std::string series = read(folder_ / "out/flow.csv");
  EXPECT_EQ(std::count(series.begin(), series.end(), '\n'), 3) << series; // header and two steps
}

TEST_F(FluidProgram, AnInflowThatIsNotANumberIsNamed) {
  const std::string text = replaced(base_config, "name: \"z0\" velocity { z: \"1\" }",
                                    "name: \"z0\" velocity { z: \"sqrt(0.02-t)\" }");
  EXPECT_EQ(run("", "run", replaced(replaced(text, "OUT", "out"), "FINAL", "last.state")), 3) << log();
  for (const char* part : {"boundary \"z0\"", "sqrt(0.02-t)", "t = 0.05"})
    EXPECT_NE(log().find(part), std::string::npos) << part << "\n" << log();
}

/// Two iterations are too few for a step of 0.4, but not for its eighths.
TEST_F(FluidProgram, AStepThatFailsIsTakenInParts) {
  std::string text = replaced(base_config, "step: 0.05 steps: 2", "step: 0.4 steps: 1");
  text = replaced(text, "max_iterations: 12", "max_iterations: 2 failure_tolerance: 7e-4");
  ASSERT_EQ(run("", "run", replaced(replaced(text, "OUT", "out"), "FINAL", "last.state")), 0) << log();
  EXPECT_NE(log().find("is taken in halves"), std::string::npos) << log();
  const auto last = io::read_state(folder_ / "last.state");
  ASSERT_TRUE(last.ok());
  EXPECT_GE(last->step, 4U); // two of the first phase at least, two of the second
  EXPECT_NEAR(last->time, 0.44, 1e-12);
}

/// A channel that comes to rest in its own time: the phase ends there, averages run from t = 0.2.
TEST_F(FluidProgram, ASteadyFlowEndsItsPhaseAndAveragesAreWritten) {
  std::string text =
      replaced(base_config, "step: 0.05 steps: 2", "step: 0.5 steps: 400 steady_tolerance: 1e-3");
  text += "averages { start: 0.2 }\n";
  ASSERT_EQ(run("", "run", replaced(replaced(text, "OUT", "out"), "FINAL", "last.state")), 0) << log();
  EXPECT_NE(log().find("steady after step "), std::string::npos) << log();
  const auto last = io::read_state(folder_ / "last.state");
  ASSERT_TRUE(last.ok());
  EXPECT_LT(last->step, 400U);
  EXPECT_NE(last->find("average_velocity_mean"), nullptr);
  const std::string averages = read(folder_ / "out/averages.csv");
  EXPECT_EQ(averages.rfind("force,time,mean_x", 0), 0U) << averages;
  EXPECT_EQ(std::count(averages.begin(), averages.end(), '\n'), 2) << averages; // header and the one report
}

/// The flow of one mesh goes on on a finer one, with nearly the force that it had.
TEST_F(FluidProgram, StartsFromTheStateOfAnotherMesh) {
  const auto force = [&](const std::string& out) { // along z, of the last step
    std::stringstream lines(read(folder_ / out / "forces.csv"));
    std::string header, row, name, cell;
    std::getline(lines, header);
    for (std::string line; std::getline(lines, line);) row = line;
    std::stringstream names(header), cells(row);
    double found = NAN;
    while (std::getline(names, name, ',') && std::getline(cells, cell, ','))
      if (name == "wall_total_z") found = std::stod(cell);
    return found;
  };
  std::string first = replaced(replaced(base_config, "OUT", "first"), "FINAL", "first.state");
  first = replaced(first, " mesh_displacement { x: \"0.05*(1-x)*sin(t)*z*(2-z)\" }", "");
  ASSERT_EQ(run("", "run", first), 0) << log();
  ASSERT_TRUE(mesh::write_msh(folder_ / "fine.msh", test::box_mesh({5, 4, 7}, {1, 1, 2})).ok());
  ASSERT_TRUE(mesh::write_msh(folder_ / "long.msh", test::box_mesh({5, 4, 7}, {1, 1, 3})).ok());
  std::string text = replaced(first, "box.msh\"", "fine.msh\"\ninitial_state: \"first.state\"");
  text = replaced(replaced(text, "\"first\" field", "\"second\" field"), "final_state: \"first.state\"",
                  "final_state: \"second.state\"");
  EXPECT_EQ(run("", "run", text), 2);
  EXPECT_NE(log().find("name its mesh as initial_state_mesh"), std::string::npos) << log();
  text = replaced(text,
                  "initial_state:", "initial_flow: PROJECTED initial_state_mesh: \"box.msh\" initial_state:");
  ASSERT_EQ(run("", "run", text), 0) << log();
  const auto last = io::read_state(folder_ / "second.state");
  ASSERT_TRUE(last.ok());
  EXPECT_EQ(last->step, 8U);
  EXPECT_NEAR(last->time, 0.28, 1e-12);
  EXPECT_NEAR(force("second"), force("first"), 0.2 * std::abs(force("first")));
  EXPECT_EQ(run("", "run", replaced(text, "fine.msh", "long.msh")), 2);
  EXPECT_NE(log().find("lies outside the state's mesh"), std::string::npos) << log();
  EXPECT_EQ(
      run("", "check", replaced(base_config, "density: 2", "density: 2 initial_state_mesh: \"box.msh\"")), 2);
  EXPECT_NE(log().find("there is none"), std::string::npos) << log();
}

TEST_F(FluidProgram, ASignalEndsTheRunAfterTheStep) {
  std::string text = replaced(base_config, "step: 0.05 steps: 2", "step: 0.001 steps: 1000000");
  text = replaced(replaced(text, "OUT", "out"), "FINAL", "last.state");
  for (const char* signal : {"TERM", "INT"}) {
    fs::remove(folder_ / "last.state");
    ASSERT_EQ(run(drogue::test::signalled(signal, "step 1/"), "run", text), 5) << log();
    EXPECT_NE(log().find("interrupted after step "), std::string::npos) << log();
    const auto last = io::read_state(folder_ / "last.state");
    ASSERT_TRUE(last.ok());
    EXPECT_GE(last->step, 1U);
    EXPECT_TRUE(fs::exists(folder_ / fmt::format("out/fluid_{:06}.vtu", last->step)));
  }
}

TEST_F(FluidProgram, ASignalEndsAParticipantThatWaits) {
  std::string text = replaced(base_config, "final_state: \"FINAL\"\n", "");
  const auto first = text.find("phase {");
  text.erase(first, text.find('\n', first) - first);
  text = replaced(text, " mesh_displacement { x: \"0.05*(1-x)*sin(t)*z*(2-z)\" }", "");
  text = replaced(text, "force {", "interface: \"x0\"\nforce {");
  ASSERT_EQ(run("DROGUE_PARTICIPANT=fluid " + drogue::test::signalled("TERM", "steps is not used"),
                "run --connect ipc://nobody", text),
            5)
      << log();
  for (const char* part : {"fluid: interrupted by a signal", "output.directory is not used in a coupled run",
                           "phase[0].steps is not used"})
    EXPECT_NE(log().find(part), std::string::npos) << part << "\n" << log();
}

TEST_F(FluidProgram, ProbesAreWrittenEveryStep) {
  const std::string text = replaced(base_config, "field_interval: 2", "field_interval: 0 series_interval: 2");
  ASSERT_EQ(run("", "run", replaced(replaced(text, "OUT", "out"), "FINAL", "end.state")), 0) << log();
  const auto lines = [&](const char* name) {
    const std::string text_of = read(folder_ / "out" / name);
    return std::count(text_of.begin(), text_of.end(), '\n');
  };
  EXPECT_EQ(lines("probes.csv"), 5);
  EXPECT_EQ(lines("forces.csv"), 3);
  EXPECT_NE(read(folder_ / "out/forces.csv").find("wall_total_x,wall_total_y,wall_total_z,wall_moment_x"),
            std::string::npos);
}

} // namespace
} // namespace drogue::fluid
