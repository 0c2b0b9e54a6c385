// SPDX-License-Identifier: GPL-3.0-or-later
// The configs of configs/t10/quick, stage by stage as scripts/demo runs them, with fewer steps of the flow
// and of the coupled run: every config passes its check, every stage ends well, and the coupled steps
// converge.
#include <regex>

#include "coupler/launcher/process.hpp"
#include "tests/support/coupled_case.hpp"

namespace drogue::test {
namespace {

namespace fs = std::filesystem;

class T10Quick : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder("run");
    for (const auto& entry : fs::directory_iterator(fs::path(DROGUE_SOURCE_DIR) / "configs/t10/quick"))
      fs::copy_file(entry.path(), folder_ / entry.path().filename());
  }
  /// Runs a program of the build in the case's folder.
  void run(const std::string& program, const std::string& command, const std::string& config) {
    fs::remove(folder_ / "output.txt"); // a process appends to its log
    auto process = launcher::Process::start({{fmt::format("{}/{}", DROGUE_BIN_DIR, program), command, config},
                                             {},
                                             folder_,
                                             folder_ / "output.txt"});
    ASSERT_TRUE(process.ok());
    const auto& exit = process->wait(std::chrono::minutes(5));
    ASSERT_TRUE(exit.has_value() && exit->clean())
        << program << " " << command << " " << config << ": " << read_text(folder_ / "output.txt");
  }
  /// Replaces every match of `pattern` in a config; there must be one.
  void shorten(const std::string& config, const std::string& pattern, const std::string& by) {
    const std::string text = read_text(folder_ / config),
                      replaced = std::regex_replace(text, std::regex(pattern), by);
    ASSERT_NE(text, replaced) << config;
    std::ofstream(folder_ / config) << replaced;
  }
  fs::path folder_;
};

TEST_F(T10Quick, RunsFromTheFlatPatternToCoupledSteps) {
  run("parachute_mesher", "check", "parachute.textproto");
  run("parachute_mesher", "structure", "parachute.textproto");
  run("structure_solver", "check", "inflation.textproto");
  run("structure_solver", "run", "inflation.textproto");
  run("parachute_mesher", "fluid", "parachute.textproto");
  shorten("flow.textproto", "steps: [0-9]+", "steps: 3");
  run("fluid_solver", "check", "flow.textproto");
  run("fluid_solver", "run", "flow.textproto");
  run("coupler", "check", "case.textproto");
  EXPECT_EQ(read_text(folder_ / "output.txt"), "case.textproto: ok\n");
  shorten("case.textproto", "steps: 60", "steps: 2");
  run("coupler", "run", "case.textproto");

  const Table drag = read_csv(folder_ / "coupled/drag.csv"),
              coupling = read_csv(folder_ / "coupled/coupling.csv");
  ASSERT_EQ(drag.rows.size(), 2u);
  for (std::size_t n = 0; n < 2; ++n) {
    EXPECT_EQ(drag.at(n, "converged"), 1);
    EXPECT_GT(drag.at(n, "force_z"), 0); // the flow from below lifts the canopy
  }
  for (std::size_t i = 0; i < coupling.rows.size(); ++i) EXPECT_LT(coupling.at(i, "force_defect"), 1e-12);
  EXPECT_LE(coupling.at(coupling.rows.size() - 1, "residual_relative"), 1e-3);
}

} // namespace
} // namespace drogue::test
