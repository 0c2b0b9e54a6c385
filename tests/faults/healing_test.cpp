// SPDX-License-Identifier: GPL-3.0-or-later
// Runs that outlive their participants: whoever is killed, whenever, all results are those of the undisturbed
// run, to the bit; and the runs that are not to be continued end at once.
#include <functional>

#include "tests/support/checkpoint_runs.hpp"
#include "tests/support/processes.hpp"

namespace drogue::test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

std::string output(const fs::path& folder) {
  return read_text(folder / "output.txt");
}

int count(const std::string& text, const std::string& word) {
  int n = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++n;
  return n;
}

/// Steps in halves now and then, a solver that takes its time, and a checkpoint at the end.
OscillatorCase long_case(const std::string& extra) {
  return {.structure_arguments = "--delay 0.002",
          .fluid_arguments = "--refuse-step 3 --delay 0.002",
          .steps = 60,
          .extra = "loop { predictor: 2 non_convergence: RETRY } " + extra};
}

std::map<std::string, std::string> undisturbed(const OscillatorCase& c) {
  const auto folder = fresh_folder("undisturbed");
  write_case(folder, c);
  EXPECT_EQ(run_coupler_with(folder, {"run", "case.textproto"}), 0) << output(folder);
  return everything(folder, c.steps);
}

/// Runs the case in `folder` while a participant dies every now and then, `kills` in all, from the checkpoint
/// of step `from` on (0: from the start). @return the kills
int disturbed_run(const fs::path& folder, int from, int kills, milliseconds between, unsigned seed) {
  std::mt19937 random(seed);
  launcher::Process coupler = start_program(folder, {"run", "case.textproto"});
  EXPECT_TRUE(from == 0 || eventually([&] { return has_checkpoint(folder, from); }));
  int killed = 0;
  while (!coupler.wait(milliseconds(random() % (2 * between.count())))) {
    if (killed == kills) continue;
    killed += kill_a_participant(coupler.pid(), folder, random) ? 1 : 0;
  }
  EXPECT_EQ(coupler.poll()->status, 0) << output(folder);
  return killed;
}

TEST(Healing, RandomKillsDoNotChangeTheResults) {
  const OscillatorCase c = long_case("checkpoints { steps: 4 } healing { restarts: 100 }");
  const auto expected = undisturbed(c);
  for (const unsigned seed : {1u, 2u}) {
    const auto folder = fresh_folder("killed");
    write_case(folder, c);
    const int killed = disturbed_run(folder, 4, 15, milliseconds(250), seed);
    EXPECT_GE(killed, 1);
    const std::string text = output(folder);
    EXPECT_GE(count(text, " of at most 100: "), 1) << text;
    EXPECT_NE(text.find("was killed by signal 9"), std::string::npos) << text;
    EXPECT_NE(text.find("the run goes on after step "), std::string::npos) << text;
    expect_same(expected, everything(folder, c.steps));
    EXPECT_EQ(left_behind(folder), 0);
  }
}

TEST(Healing, WithoutACheckpointTheRunStartsAgain) {
  OscillatorCase c = long_case("healing { restarts: 20 } checkpoints { steps: 60 }");
  const auto expected = undisturbed(c);
  const auto folder = fresh_folder("killed");
  write_case(folder, c);
  EXPECT_EQ(disturbed_run(folder, 0, 3, milliseconds(300), 3), 3);
  EXPECT_NE(output(folder).find("the run goes on from its start"), std::string::npos) << output(folder);
  expect_same(expected, everything(folder, c.steps));
}

/// Whatever the participant was asked when it stopped: every wait on it is short.
TEST(Healing, AParticipantThatStopsAnsweringIsReplaced) {
  OscillatorCase c =
      long_case("checkpoints { steps: 10 } healing { restarts: 1 } deadlines { iterate: 2 other: 2 }");
  const auto expected = undisturbed(c);
  const auto folder = fresh_folder("stopped");
  write_case(folder, c);
  launcher::Process coupler = start_program(folder, {"run", "case.textproto"});
  ASSERT_TRUE(eventually([&] { return has_checkpoint(folder, 10); })) << output(folder);
  const std::string text = output(folder), mark = "fluid started, pid ";
  ASSERT_EQ(kill(std::stoi(text.substr(text.find(mark) + mark.size())), SIGSTOP), 0);
  const auto exit = coupler.wait(std::chrono::seconds(60));
  ASSERT_TRUE(exit.has_value()) << output(folder);
  EXPECT_EQ(exit->status, 0) << output(folder);
  EXPECT_NE(output(folder).find("within 2 s"), std::string::npos) << output(folder);
  expect_same(expected, everything(folder, c.steps));
  EXPECT_EQ(left_behind(folder), 0);
}

/// Twenty steps are between checkpoints, so that the one after it is far when the coupler is stopped.
TEST(Healing, ADamagedCheckpointIsPassedOver) {
  OscillatorCase c = long_case("checkpoints { steps: 20 keep: 9 } healing { restarts: 1 }");
  const auto expected = undisturbed(c);
  const auto folder = fresh_folder("damaged");
  write_case(folder, c);
  launcher::Process coupler = start_program(folder, {"run", "case.textproto"});
  std::mt19937 random(1);
  ASSERT_TRUE(eventually([&] { return has_checkpoint(folder, 40); })) << output(folder);
  ASSERT_EQ(kill(coupler.pid(), SIGSTOP), 0);
  std::ofstream(checkpoint_folder(folder, 40) / "fluid/plate") << "cut";
  ASSERT_FALSE(has_checkpoint(folder, 60));
  ASSERT_TRUE(kill_a_participant(coupler.pid(), folder, random));
  ASSERT_EQ(kill(coupler.pid(), SIGCONT), 0);
  const auto exit = coupler.wait(std::chrono::seconds(60));
  ASSERT_TRUE(exit.has_value()) << output(folder);
  EXPECT_EQ(exit->status, 0) << output(folder);
  EXPECT_NE(output(folder).find("the checkpoint of step 40 is not used"), std::string::npos)
      << output(folder);
  EXPECT_NE(output(folder).find("the run goes on after step 20"), std::string::npos) << output(folder);
  expect_same(expected, everything(folder, c.steps));
}

/// A run whose fluid dies once; its status.
int status_after_a_death(const fs::path& folder, const OscillatorCase& c,
                         const std::function<void(launcher::Process&)>& before) {
  write_case(folder, c);
  launcher::Process coupler = start_program(folder, {"run", "case.textproto"});
  EXPECT_TRUE(eventually([&] { return output(folder).find("step 2/") != std::string::npos; }));
  before(coupler);
  std::mt19937 random(1);
  EXPECT_TRUE(kill_a_participant(coupler.pid(), folder, random));
  const auto exit = coupler.wait(std::chrono::seconds(60));
  EXPECT_EQ(left_behind(folder), 0);
  return exit ? exit->status : -1;
}

TEST(Healing, IsOffByDefaultForForeignPrograms) {
  const auto folder = fresh_folder("run");
  EXPECT_EQ(status_after_a_death(folder, long_case(""), [](auto&) {}), 4);
  EXPECT_EQ(output(folder).find("restart"), std::string::npos) << output(folder);
}

TEST(Healing, EndsWhenTheRestartsAreUsedUp) {
  const auto folder = fresh_folder("run");
  const auto kill_one = [&](launcher::Process& coupler) {
    std::mt19937 random(2);
    EXPECT_TRUE(kill_a_participant(coupler.pid(), folder, random));
    EXPECT_TRUE(eventually([&] { return count(output(folder), "step 2/") == 2; })) << output(folder);
  };
  EXPECT_EQ(status_after_a_death(folder, long_case("healing { restarts: 1 }"), kill_one), 4);
  EXPECT_NE(output(folder).find("no restart is left of the 1"), std::string::npos) << output(folder);
}

TEST(Healing, DoesNotMixInputs) {
  const auto folder = fresh_folder("run");
  OscillatorCase c = long_case("healing { restarts: 1 }");
  c.structure_arguments += " --mesh " + (folder / "mesh").string();
  std::ofstream(folder / "mesh") << "one";
  const auto change = [&](launcher::Process&) { std::ofstream(folder / "mesh") << "two"; };
  EXPECT_EQ(status_after_a_death(folder, c, change), 4);
  EXPECT_NE(output(folder).find("a config or a mesh has changed"), std::string::npos) << output(folder);
}

TEST(Healing, AProgramThatRefusesItsConfigIsNotStartedAgain) {
  const auto folder = fresh_folder("run");
  OscillatorCase c{.extra = "healing { restarts: 5 }"};
  const auto file = write_case(folder, c);
  std::string text = read_text(file);
  const std::string ours = participant_text("fluid", "");
  text.replace(text.find(ours), ours.size(), "fluid { command: 'ls' argument: '/no/such/folder' }\n");
  std::ofstream(file) << text;
  EXPECT_EQ(run_coupler_with(folder, {"run", "case.textproto"}), 4);
  EXPECT_EQ(output(folder).find("restart"), std::string::npos) << output(folder);
}

} // namespace
} // namespace drogue::test
