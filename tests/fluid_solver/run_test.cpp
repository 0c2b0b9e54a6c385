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

TEST_F(FluidProgram, TwoRanksGiveWhatOneGives) {
  const std::string text = replaced(base_config, "OUT", "one");
  ASSERT_EQ(run("", "run", replaced(text, "FINAL", "one.state")), 0) << log();
  ASSERT_EQ(run("mpiexec --oversubscribe -n 2", "run",
                replaced(replaced(base_config, "OUT", "two"), "FINAL", "two.state")),
            0)
      << log();
  const auto one = io::read_state(folder_ / "one.state");
  const auto two = io::read_state(folder_ / "two.state");
  ASSERT_TRUE(one.ok() && two.ok());
  EXPECT_NEAR(one->time, 0.14, 1e-12);
  EXPECT_EQ(one->step, 4U);
  for (const char* name : {"velocity", "pressure"}) {
    const auto& a = one->find(name)->values;
    const auto& b = two->find(name)->values;
    ASSERT_EQ(a.size(), b.size());
    double size = 0;
    for (const double value : a) size = std::max(size, std::abs(value));
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-6 * size) << name;
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

TEST_F(FluidProgram, AProbeOutsideAndATiltedSlipPlaneAreRefused) {
  mesh::Mesh tilted = test::box_mesh({2, 2, 2}, {1, 1, 2});
  for (std::size_t i = 0; i < tilted.points.size(); i += 3) tilted.points[i] += 0.1 * tilted.points[i + 2];
  ASSERT_TRUE(mesh::write_msh(folder_ / "box.msh", tilted).ok());
  EXPECT_EQ(run("", "check", replaced(base_config, "z: 1 }\noutput", "z: 7 }\noutput")), 2);
  EXPECT_NE(log().find("free_slip needs planes normal to x, y or z"), std::string::npos) << log();
  EXPECT_NE(log().find("lies outside the fluid"), std::string::npos) << log();
}

TEST_F(FluidProgram, AStepThatFailsEndsWithStatusThree) {
  std::string text = replaced(base_config, "residual_tolerance: 1e-9 max_iterations: 12",
                              "residual_tolerance: 1e-14 max_iterations: 1 failure_tolerance: 1e-13");
  EXPECT_EQ(run("", "run", text), 3) << log();
  EXPECT_NE(log().find("failed"), std::string::npos);
}

} // namespace
} // namespace drogue::fluid
