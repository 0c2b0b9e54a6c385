// SPDX-License-Identifier: GPL-3.0-or-later
// Death and silence of participants: the culprit is named, the status is 4, nobody is left behind.
#include <csignal>
#include <regex>
#include <thread>

#include <sys/wait.h>
#include <unistd.h>

#include "coupler/launcher/process.hpp"
#include "tests/support/coupled_case.hpp"
#include "tests/support/processes.hpp"

namespace drogue::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

launcher::Process start_coupler(const std::filesystem::path& case_file) {
  auto process =
      launcher::Process::start({{std::string(DROGUE_BIN_DIR) + "/coupler", "run", case_file.string()},
                                {},
                                case_file.parent_path(),
                                case_file.parent_path() / "output.txt"});
  EXPECT_TRUE(process.ok());
  return std::move(*process);
}

/// The pid the coupler logged for a participant, once the first step is under way.
pid_t pid_of(const std::string& role, const std::filesystem::path& folder) {
  const std::regex line(role + " started, pid ([0-9]+)");
  for (int i = 0; i < 500; ++i) {
    const std::string text = read_text(folder / "output.txt");
    std::smatch match;
    if (std::regex_search(text, match, line) && text.find("surfaces paired") != std::string::npos)
      return std::stoi(match[1]);
    std::this_thread::sleep_for(10ms);
  }
  return -1;
}

class Kill : public testing::TestWithParam<const char*> {};

TEST_P(Kill, SigkillInTheMiddleOfAStepNamesTheCulprit) {
  const std::string victim = GetParam();
  const auto folder = fresh_folder(victim);
  OscillatorCase c{.structure_arguments = "--delay 0.3",
                   .fluid_arguments = "--delay 0.3",
                   .mesh_mover_arguments = "--delay 0.3",
                   .steps = 1000};
  launcher::Process coupler = start_coupler(write_case(folder, c));
  const pid_t pid = pid_of(victim, folder);
  ASSERT_GT(pid, 0) << read_text(folder / "output.txt");
  std::this_thread::sleep_for(500ms);

  const auto killed_at = Clock::now();
  ASSERT_EQ(kill(pid, SIGKILL), 0);
  const auto exit = coupler.wait(10s);
  ASSERT_TRUE(exit.has_value());
  EXPECT_LT(Clock::now() - killed_at, 2s);
  EXPECT_EQ(exit->status, 4);
  const std::string text = read_text(folder / "output.txt");
  EXPECT_NE(text.find(fmt::format("{} (pid {}) was killed by signal 9", victim, pid)), std::string::npos)
      << text;
  EXPECT_NE(text.find("plate of "), std::string::npos) << "the last log lines are missing: " << text;
  EXPECT_EQ(left_behind(folder), 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "run/coupling.csv"));
}

INSTANTIATE_TEST_SUITE_P(EachParticipant, Kill, testing::Values("structure", "fluid", "mesh_mover"),
                         [](const auto& kind) { return std::string(kind.param); });

TEST(Faults, SigkillOfARankIsNoticedLikeThatOfTheProcess) {
  const auto folder = fresh_folder("rank");
  launcher::Process coupler =
      start_coupler(write_case(folder, {.fluid_arguments = "--second-rank yes --delay 0.3", .steps = 1000}));
  ASSERT_GT(pid_of("fluid", folder), 0);
  const std::string log = read_text(folder / "run/fluid.log");
  std::smatch match;
  ASSERT_TRUE(std::regex_search(log, match, std::regex("second rank ([0-9]+)"))) << log;
  ASSERT_EQ(kill(std::stoi(match[1]), SIGKILL), 0);
  const auto exit = coupler.wait(2s);
  ASSERT_TRUE(exit.has_value());
  EXPECT_EQ(exit->status, 4);
  const std::string text = read_text(folder / "output.txt");
  EXPECT_NE(text.find(fmt::format("fluid (pid {}) is one of its ranks and ended", match[1].str())),
            std::string::npos)
      << text;
  EXPECT_EQ(left_behind(folder), 0);
}

TEST(Faults, AProgramThatEndsBeforeHelloIsNamedWithItsLastWords) {
  const auto folder = fresh_folder("early");
  const auto file = write_case(folder, {});
  std::string text = read_text(file);
  text += "deadlines { connect: 5 }\n";
  const std::string ours = participant_text("fluid", "");
  text.replace(text.find(ours), ours.size(), "fluid { command: 'ls' argument: '/no/such/folder' }\n");
  std::ofstream(file) << text;
  launcher::Process coupler = start_coupler(file);
  const auto exit = coupler.wait(10s);
  ASSERT_TRUE(exit.has_value());
  EXPECT_EQ(exit->status, 4);
  const std::string output = read_text(folder / "output.txt");
  EXPECT_NE(output.find("exited with status 2 before it said Hello"), std::string::npos) << output;
  EXPECT_EQ(left_behind(folder), 0);
}

TEST(Faults, AParticipantThatHangsIsNamedAfterTheDeadline) {
  const auto folder = fresh_folder("hang");
  launcher::Process coupler = start_coupler(
      write_case(folder, {.fluid_arguments = "--delay 1000", .extra = "deadlines { iterate: 2.5 }"}));
  const auto exit = coupler.wait(15s);
  ASSERT_TRUE(exit.has_value());
  EXPECT_EQ(exit->status, 4);
  const std::string output = read_text(folder / "output.txt");
  EXPECT_NE(output.find("did not answer Iterate of step 1, iteration 1 within 2.5 s"), std::string::npos)
      << output;
  EXPECT_EQ(left_behind(folder), 0);
}

TEST(Faults, SigtermEndsTheRunWithStatusFive) {
  const auto folder = fresh_folder("sigterm");
  launcher::Process coupler =
      start_coupler(write_case(folder, {.fluid_arguments = "--delay 0.1", .steps = 1000}));
  ASSERT_GT(pid_of("fluid", folder), 0);
  kill(coupler.pid(), SIGTERM);
  const auto exit = coupler.wait(10s);
  ASSERT_TRUE(exit.has_value());
  EXPECT_EQ(exit->status, 5);
  EXPECT_EQ(left_behind(folder), 0);
}

TEST(Faults, ParticipantsEndWhenTheCouplerIsKilled) {
  const auto folder = fresh_folder("orphans");
  launcher::Process coupler =
      start_coupler(write_case(folder, {.fluid_arguments = "--delay 0.2", .steps = 1000}));
  ASSERT_GT(pid_of("fluid", folder), 0);
  kill(coupler.pid(), SIGKILL);
  for (int i = 0; i < 200 && left_behind(folder) > 0; ++i) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(left_behind(folder), 0);
}

} // namespace
} // namespace drogue::test
