// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <regex>

#include "tests/support/checkpoint_runs.hpp"

/// The configs of configs/t10/quick, stage by stage as scripts/demo runs them.
namespace drogue::test {

class T10Quick : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder("run");
    for (const auto& entry :
         std::filesystem::directory_iterator(std::filesystem::path(DROGUE_SOURCE_DIR) / "configs/t10/quick"))
      if (entry.is_regular_file()) // not the folders of variants
        std::filesystem::copy_file(entry.path(), folder_ / entry.path().filename());
  }
  /// Runs a program of the build in the case's folder.
  void run(const std::string& program, const std::string& command, const std::string& config,
           std::chrono::minutes deadline = std::chrono::minutes(5)) {
    std::filesystem::remove(folder_ / "output.txt"); // a process appends to its log
    auto process = launcher::Process::start({{fmt::format("{}/{}", DROGUE_BIN_DIR, program), command, config},
                                             {},
                                             folder_,
                                             folder_ / "output.txt"});
    ASSERT_TRUE(process.ok());
    const auto& exit = process->wait(deadline);
    ASSERT_TRUE(exit.has_value() && exit->clean())
        << program << " " << command << " " << config << ": " << read_text(folder_ / "output.txt");
  }
  /// Replaces every match of `pattern` in a config; there must be one.
  void change(const std::string& config, const std::string& pattern, const std::string& by) {
    const std::string text = read_text(folder_ / config),
                      replaced = std::regex_replace(text, std::regex(pattern), by);
    ASSERT_NE(text, replaced) << config;
    std::ofstream(folder_ / config) << replaced;
  }
  /// Everything before the coupled run; of each phase of the flow 3 steps.
  void prepare() {
    run("parachute_mesher", "structure", "parachute.textproto");
    run("structure_solver", "run", "inflation.textproto");
    run("parachute_mesher", "fluid", "parachute.textproto");
    change("flow.textproto", "steps: [0-9]+", "steps: 3");
    run("fluid_solver", "run", "flow.textproto");
  }
  std::filesystem::path folder_;
};

} // namespace drogue::test
