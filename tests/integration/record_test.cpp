// SPDX-License-Identifier: GPL-3.0-or-later
// A run is recorded, and its messages played again to each of its solvers alone: the same answers to the bit;
// and a solver that answers otherwise is found out, with the first request where it does.
#include "tests/support/checkpoint_runs.hpp"

namespace drogue::test {
namespace {

namespace fs = std::filesystem;

class Record : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder("run");
    write_case(folder_, {.fluid_arguments = "--refuse-step 3",
                         .steps = 4,
                         .extra = "loop { non_convergence: RETRY } checkpoints { steps: 2 }"});
    ASSERT_EQ(run_coupler_with(folder_, {"run", "--record", "case.textproto"}), 0) << output();
  }
  [[nodiscard]] std::string output() const { return read_text(folder_ / "output.txt"); }
  int replay(const std::string& record, std::vector<std::string> program) {
    std::vector<std::string> command{"replay", "--folder",
                                     "again",  "run/record/" + record,
                                     "--",     std::string(DROGUE_TEST_BIN_DIR) + "/oscillator_participant"};
    command.insert(command.end(), program.begin(), program.end());
    return run_coupler_with(folder_, command);
  }
  fs::path folder_;
};

TEST_F(Record, EachSolverAnswersAsItDid) {
  EXPECT_EQ(replay("structure.record", {"structure"}), 0) << output();
  EXPECT_NE(output().find("structure: "), std::string::npos);
  EXPECT_NE(output().find(" requests, 0 answers differ from the record"), std::string::npos) << output();
  EXPECT_EQ(replay("mesh_mover.record", {"mesh_mover"}), 0) << output();
  EXPECT_EQ(replay("fluid.record", {"fluid", "--refuse-step", "3"}), 0) << output();
}

TEST_F(Record, AnotherAnswerIsFound) {
  EXPECT_EQ(replay("structure.record", {"structure", "--velocity", "1e-9"}), 4);
  EXPECT_NE(output().find("Initialize: "), std::string::npos) << output();
  EXPECT_NE(output().find("Iterate of step 1, iteration 1: "), std::string::npos) << output();
  EXPECT_NE(output().find("does not answer as it did in the recorded run"), std::string::npos) << output();
  EXPECT_EQ(replay("fluid.record", {"fluid"}), 4);
  EXPECT_NE(output().find("Iterate of step 3, iteration 1: Iterated in place of Error"), std::string::npos)
      << output();
}

TEST_F(Record, AResumedRunHasARecordOfItsOwnWhichIsReplayedFromTheCheckpoint) {
  std::string text = read_text(folder_ / "case.textproto");
  text.replace(text.find("steps: 4"), 8, "steps: 6");
  std::ofstream(folder_ / "case.textproto") << text;
  ASSERT_EQ(run_coupler_with(folder_, {"resume", "--record", "run"}), 0) << output();
  EXPECT_EQ(replay("structure.2.record", {"structure"}), 0) << output();
}

TEST_F(Record, ARecordThatIsCutShortIsPlayedToItsEnd) {
  const auto file = folder_ / "run/record/structure.record";
  fs::resize_file(file, fs::file_size(file) / 2);
  EXPECT_EQ(replay("structure.record", {"structure"}), 0) << output();
  std::ofstream(file, std::ios::in | std::ios::out | std::ios::binary) << "something else";
  EXPECT_EQ(replay("structure.record", {"structure"}), 2) << output();
}

} // namespace
} // namespace drogue::test
