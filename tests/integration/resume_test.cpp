// SPDX-License-Identifier: GPL-3.0-or-later
// Checkpoints of coupled runs, and runs continued from them: every result, and the state at the end, must be
// those of the run that was not disturbed, to the bit.
#include "tests/support/checkpoint_runs.hpp"

namespace drogue::test {
namespace {

namespace fs = std::filesystem;

/// Steps in halves now and then, so that two step lengths have secants of their own.
OscillatorCase demanding(const std::string& extra = "") {
  return {.fluid_arguments = "--refuse-step 3",
          .steps = 12,
          .extra = "loop { predictor: 2 non_convergence: RETRY }" + extra};
}

/// The results of an undisturbed run with a checkpoint at its end.
std::map<std::string, std::string> undisturbed(const OscillatorCase& c) {
  const auto folder = fresh_folder("undisturbed");
  write_case(folder, c);
  EXPECT_EQ(run_coupler_with(folder, {"run", "case.textproto"}), 0) << read_text(folder / "output.txt");
  return everything(folder, c.steps);
}

/// A run that ended after `steps` steps, as if the case had no more.
fs::path partial_run(OscillatorCase c, int steps) {
  const auto folder = fresh_folder("resumed");
  const int all = c.steps;
  c.steps = steps;
  write_case(folder, c);
  EXPECT_EQ(run_coupler_with(folder, {"run", "case.textproto"}), 0) << read_text(folder / "output.txt");
  c.steps = all;
  write_case(folder, c);
  return folder;
}

std::string output(const fs::path& folder) {
  return read_text(folder / "output.txt");
}

TEST(Resume, NPlusMStepsAreNStepsResumedForM) {
  for (const char* acceleration : {"", "acceleration { method: AITKEN relaxation: 0.1 } ",
                                   "acceleration { method: CONSTANT relaxation: 0.1 } "}) {
    OscillatorCase c = demanding(fmt::format(" {} checkpoints {{ steps: 4 }}", acceleration));
    c.extra.replace(c.extra.find("predictor"), 0, "max_iterations: 400 ");
    const auto folder = partial_run(c, 4);
    ASSERT_EQ(run_coupler_with(folder, {"resume", "run"}), 0) << output(folder);
    expect_same(undisturbed(c), everything(folder, 12));
    EXPECT_NE(output(folder).find("12 steps (done in 13 parts)"), std::string::npos) << output(folder);
  }
}

OscillatorCase with_new_mesh(const std::string& fluid_arguments) {
  return {.fluid_arguments = fluid_arguments,
          .mesh_mover_arguments = "--new-mesh 3 --replaces-mesh yes",
          .steps = 8,
          .extra = "checkpoints { steps: 2 }"};
}

// The interface does not change with the mesh: neither does what the coupling does.
TEST(NewMesh, IsHandedOnAndComesBackOnResume) {
  const OscillatorCase c = with_new_mesh("--replaces-mesh yes");
  const auto expected = undisturbed(c);
  const auto folder = partial_run(c, 6);
  const Table remesh = read_csv(folder / "run/remesh.csv");
  ASSERT_EQ(remesh.rows.size(), 1u);
  EXPECT_EQ(remesh.at(0, "step"), 3);
  EXPECT_EQ(remesh.at(0, "nodes_after"), remesh.at(0, "nodes_before") + 2);
  EXPECT_EQ(remesh.at(0, "momentum_defect"), 0.02);
  EXPECT_NE(read_text(checkpoint_folder(folder, 6) / "manifest.textproto").find("mesh_mover/other.msh"),
            std::string::npos);
  ASSERT_EQ(run_coupler_with(folder, {"resume", "run"}), 0) << output(folder);
  expect_same(expected, everything(folder, 8));

  OscillatorCase without = c;
  without.mesh_mover_arguments = "";
  auto same = undisturbed(without);
  EXPECT_EQ(same.at("drag.csv"), expected.at("drag.csv"));
  EXPECT_EQ(same.at("coupling.csv"), expected.at("coupling.csv"));
}

TEST(NewMesh, ACheckpointWhoseMeshWasAlteredIsNotUsed) {
  const auto folder = partial_run(with_new_mesh("--replaces-mesh yes"), 4);
  std::ofstream(folder / "run/mesh_mover/other.msh") << "three nodes";
  ASSERT_EQ(run_coupler_with(folder, {"resume", "run"}), 0) << output(folder);
  EXPECT_NE(output(folder).find("other.msh has 11 bytes in place of 18"), std::string::npos)
      << output(folder);
  EXPECT_NE(output(folder).find("goes on after step 2"), std::string::npos) << output(folder);
}

TEST(NewMesh, AFluidThatCannotTakeItEndsTheRun) {
  const auto folder = fresh_folder("run");
  write_case(folder, with_new_mesh(""));
  EXPECT_EQ(run_coupler_with(folder, {"run", "case.textproto"}), 2);
  EXPECT_NE(
      output(folder).find("the mesh must be replaced after step 3 (worn after so many steps), but fluid "
                          "(oscillator fluid) cannot take another mesh"),
      std::string::npos)
      << output(folder);
}

TEST(Resume, ContinuesAfterTheCouplerWasKilledInAStep) {
  OscillatorCase c = demanding(" checkpoints { steps: 2 keep: 3 }");
  const auto expected = undisturbed(c);
  c.structure_arguments = "--delay 0.02";
  const auto folder = fresh_folder("resumed");
  write_case(folder, c);
  for (int i = 0; i < 3; ++i) {
    launcher::Process coupler =
        i == 0 ? start_program(folder, {"run", "case.textproto"}) : start_program(folder, {"resume", "run"});
    ASSERT_TRUE(eventually([&] { return has_checkpoint(folder, 2 * (i + 1)); })) << output(folder);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    kill(coupler.pid(), SIGKILL);
    ASSERT_TRUE(coupler.wait(std::chrono::seconds(10)).has_value());
  }
  ASSERT_EQ(run_coupler_with(folder, {"resume", "run"}), 0) << output(folder);
  expect_same(expected, everything(folder, 12));
}

TEST(Resume, ContinuesAfterTheDeathOfAParticipant) {
  const OscillatorCase c{.fluid_arguments = "--delay 0.03", .steps = 12, .extra = "checkpoints { steps: 4 }"};
  const auto folder = fresh_folder("resumed");
  write_case(folder, c);
  launcher::Process coupler = start_program(folder, {"run", "case.textproto"});
  ASSERT_TRUE(eventually([&] { return has_checkpoint(folder, 4); })) << output(folder);
  const std::string text = output(folder), mark = "fluid started, pid ";
  ASSERT_EQ(kill(std::stoi(text.substr(text.find(mark) + mark.size())), SIGKILL), 0);
  const auto exit = coupler.wait(std::chrono::seconds(10));
  ASSERT_TRUE(exit.has_value());
  EXPECT_EQ(exit->status, 4);
  EXPECT_NE(output(folder).find("there is a checkpoint of step "), std::string::npos) << output(folder);
  ASSERT_EQ(run_coupler_with(folder, {"resume", "run"}), 0) << output(folder);
  expect_same(undisturbed(c), everything(folder, 12));
}

TEST(Resume, SigtermInTheFirstStepLeavesACheckpointOfTheStart) {
  OscillatorCase c{.fluid_arguments = "--delay 0.3", .steps = 4, .extra = "checkpoints { steps: 4 }"};
  const auto folder = fresh_folder("resumed");
  write_case(folder, c);
  launcher::Process coupler = start_program(folder, {"run", "case.textproto"});
  ASSERT_TRUE(eventually([&] { return fs::exists(folder / "run/coupling.csv"); })) << output(folder);
  std::this_thread::sleep_for(std::chrono::milliseconds(150)); // in the first iterate
  kill(coupler.pid(), SIGTERM);
  const auto exit = coupler.wait(std::chrono::seconds(30));
  ASSERT_TRUE(exit.has_value());
  EXPECT_EQ(exit->status, 5);
  EXPECT_TRUE(has_checkpoint(folder, 0)) << output(folder);
  EXPECT_NE(output(folder).find("stopped by a signal after step 0 of 4; continue it with: coupler resume"),
            std::string::npos)
      << output(folder);
  ASSERT_EQ(run_coupler_with(folder, {"resume", "run"}), 0) << output(folder);
  c.fluid_arguments = "";
  expect_same(undisturbed(c), everything(folder, 4));
}

TEST(Resume, SigtermTakesTheStepBackAndLeavesACheckpoint) {
  for (const char* rolls_back : {"yes", "no"}) {
    OscillatorCase c{.fluid_arguments = fmt::format("--delay 0.05 --rolls-back {}", rolls_back),
                     .steps = 12,
                     .extra = "checkpoints { steps: 12 }"};
    const auto folder = fresh_folder("resumed");
    write_case(folder, c);
    launcher::Process coupler = start_program(folder, {"run", "case.textproto"});
    ASSERT_TRUE(eventually([&] { return output(folder).find("step 3/12") != std::string::npos; }))
        << output(folder);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    kill(coupler.pid(), SIGTERM);
    const auto exit = coupler.wait(std::chrono::seconds(30));
    ASSERT_TRUE(exit.has_value());
    EXPECT_EQ(exit->status, 5);
    EXPECT_NE(output(folder).find("of 12; continue it with: coupler resume " + (folder / "run").string()),
              std::string::npos)
        << output(folder);
    ASSERT_EQ(run_coupler_with(folder, {"resume", "run"}), 0) << output(folder);
    expect_same(undisturbed(c), everything(folder, 12));
  }
}

TEST(Resume, ACheckpointIsWrittenOnDemand) {
  OscillatorCase c{.fluid_arguments = "--delay 0.05", .steps = 1000};
  const auto folder = fresh_folder("run");
  write_case(folder, c);
  launcher::Process coupler = start_program(folder, {"run", "case.textproto"});
  ASSERT_TRUE(eventually([&] { return output(folder).find("step 1/1000") != std::string::npos; }))
      << output(folder);
  EXPECT_FALSE(fs::exists(folder / "run/checkpoints"));
  const auto asker = folder / "asker";
  fs::create_directories(asker);
  EXPECT_EQ(run_coupler_with(asker, {"checkpoint", (folder / "run").string()}), 0) << output(asker);
  EXPECT_EQ(output(asker).rfind("checkpoint of step ", 0), 0u) << output(asker);
  EXPECT_FALSE(fs::is_empty(folder / "run/checkpoints"));
  kill(coupler.pid(), SIGKILL);
  ASSERT_TRUE(coupler.wait(std::chrono::seconds(10)).has_value());
  EXPECT_EQ(run_coupler_with(asker, {"checkpoint", (folder / "run").string()}), 2);
  EXPECT_NE(output(asker).find("no coupler runs in"), std::string::npos) << output(asker);
}

TEST(Resume, OldCheckpointsAreRemoved) {
  const auto folder = partial_run({.steps = 9, .extra = "checkpoints { time: 0.04 keep: 3 }"}, 9);
  for (const int step : {1, 2, 3, 4, 5, 7}) EXPECT_FALSE(has_checkpoint(folder, step)) << step;
  for (const int step : {6, 8, 9}) EXPECT_TRUE(has_checkpoint(folder, step)) << step; // 9: the end
}

TEST(Resume, WallClockTimeAsksForCheckpointsToo) {
  const auto folder = partial_run({.steps = 2, .extra = "checkpoints { wall_clock: 1e-6 }"}, 2);
  EXPECT_TRUE(has_checkpoint(folder, 1) && has_checkpoint(folder, 2));
}

TEST(Resume, FromAnEarlierCheckpointRemovesTheLaterOnes) {
  const OscillatorCase c = demanding(" checkpoints { steps: 2 keep: 9 }");
  const auto folder = partial_run(c, 10);
  EXPECT_EQ(run_coupler_with(folder, {"resume", "run", "--from", "5"}), 2);
  EXPECT_NE(output(folder).find("no checkpoint of step 5; there are those of steps 2, 4, 6, 8, 10"),
            std::string::npos)
      << output(folder);
  ASSERT_EQ(run_coupler_with(folder, {"resume", "run", "--from", "4"}), 0) << output(folder);
  EXPECT_NE(output(folder).find("checkpoint of step 6, after the one in use, is removed"), std::string::npos);
  expect_same(undisturbed(c), everything(folder, 12));
}

TEST(Resume, NothingIsLeftToDo) {
  const auto folder = partial_run({.steps = 3, .extra = "checkpoints { steps: 3 }"}, 3);
  EXPECT_EQ(run_coupler_with(folder, {"resume", "run"}), 0);
  EXPECT_NE(output(folder).find("nothing is left to do"), std::string::npos) << output(folder);
}

/// What can happen to a file of the newest checkpoint.
struct Damage {
  const char* file;
  void (*by)(const fs::path&);
  const char* message;
};
void cut_short(const fs::path& file) {
  fs::resize_file(file, fs::file_size(file) - 3);
}
void alter(const fs::path& file) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekg(20);
  const int byte = stream.get();
  stream.seekp(20);
  stream.put(static_cast<char>(byte ^ 1));
}
void erase(const fs::path& file) {
  fs::remove(file);
}

TEST(Resume, ADamagedCheckpointIsReportedAndTheOneBeforeItUsed) {
  const OscillatorCase c = demanding(" checkpoints { steps: 4 }");
  const auto expected = undisturbed(c);
  for (const Damage& damage : {Damage{"fluid/plate", cut_short, "has 21 bytes in place of 24"},
                               Damage{"structure/plate", alter, "was altered: its checksum is wrong"},
                               Damage{"coupler.state", erase, "No such file"},
                               Damage{"manifest.textproto", cut_short, "was cut short or altered"},
                               Damage{"manifest.textproto", alter, "was cut short or altered"},
                               Damage{"manifest.textproto", erase, "goes on after step 4"}}) {
    const auto folder = partial_run(c, 8);
    damage.by(checkpoint_folder(folder, 8) / damage.file);
    ASSERT_EQ(run_coupler_with(folder, {"resume", "run"}), 0) << output(folder);
    EXPECT_NE(output(folder).find(damage.message), std::string::npos)
        << damage.file << ": " << output(folder);
    EXPECT_NE(output(folder).find("goes on after step 4"), std::string::npos) << output(folder);
    expect_same(expected, everything(folder, 12));
  }
}

TEST(Resume, AChangedCaseIsRefusedUnlessAccepted) {
  OscillatorCase c{.steps = 6, .extra = "checkpoints { steps: 2 }"};
  const auto folder = partial_run(c, 4);
  c.fluid_arguments = "--delay 0.001";
  write_case(folder, c);
  EXPECT_EQ(run_coupler_with(folder, {"resume", "run"}), 2);
  EXPECT_NE(output(folder).find("case.textproto has changed"), std::string::npos) << output(folder);
  EXPECT_EQ(run_coupler_with(folder, {"resume", "run", "--accept-changes"}), 0) << output(folder);
  EXPECT_NE(output(folder).find("accepted as asked"), std::string::npos) << output(folder);
}

TEST(Resume, AResultFileThatWasCutIsRefused) {
  const auto folder = partial_run({.steps = 6, .extra = "checkpoints { steps: 2 }"}, 4);
  cut_short(folder / "run/drag.csv");
  EXPECT_EQ(run_coupler_with(folder, {"resume", "run"}), 2);
  EXPECT_NE(output(folder).find("drag.csv has"), std::string::npos) << output(folder);
}

TEST(Resume, IsRefusedWithoutACheckpointAndWhileTheRunGoesOn) {
  const auto folder = partial_run({.steps = 2}, 1);
  EXPECT_EQ(run_coupler_with(folder, {"resume", "run"}), 2);
  EXPECT_NE(output(folder).find("holds no checkpoint"), std::string::npos) << output(folder);
  EXPECT_EQ(run_coupler_with(folder, {"resume", "."}), 2);
  EXPECT_NE(output(folder).find("is not the folder of a run"), std::string::npos) << output(folder);

  const auto other = fresh_folder("running");
  write_case(other, {.fluid_arguments = "--delay 0.1", .steps = 1000, .extra = "checkpoints { steps: 1 }"});
  launcher::Process coupler = start_program(other, {"run", "case.textproto"});
  ASSERT_TRUE(eventually([&] { return has_checkpoint(other, 1); })) << output(other);
  EXPECT_EQ(run_coupler_with(folder, {"resume", (other / "run").string()}), 2);
  EXPECT_NE(output(folder).find(fmt::format("another coupler (pid {}) runs in", coupler.pid())),
            std::string::npos)
      << output(folder);
}

/// The rows of a .csv file, as text.
std::vector<std::string> lines_of(const fs::path& file) {
  std::istringstream text(read_text(file));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

TEST(StartFrom, GoesOnFromTheEndOfAnotherRun) {
  OscillatorCase c = with_new_mesh("--replaces-mesh yes");
  const std::string expected = undisturbed(c).at("drag.csv"); // 8 steps
  const auto earlier = fresh_folder("earlier");
  c.steps = 5; // no multiple of the interval: the end is kept in any case
  write_case(earlier, c);
  ASSERT_EQ(run_coupler_with(earlier, {"run", "case.textproto"}), 0) << output(earlier);

  const auto folder = fresh_folder("run");
  c.steps = 8;
  c.extra += fmt::format(" start_from: '{}'", (earlier / "run").string());
  write_case(folder, c);
  ASSERT_EQ(run_coupler_with(folder, {"run", "case.textproto"}), 0) << output(folder);
  EXPECT_NE(output(folder).find("goes on from step 5"), std::string::npos) << output(folder);
  const auto rest = lines_of(folder / "run/drag.csv");
  ASSERT_EQ(rest.size(), 1u + 3u);
  for (std::size_t row = 1; row < rest.size(); ++row)
    EXPECT_NE(expected.find(rest[row]), std::string::npos) << rest[row];
  fs::remove_all(earlier);
  c.steps = 9;
  write_case(folder, c);
  ASSERT_EQ(run_coupler_with(folder, {"resume", "run"}), 0) << output(folder);
  EXPECT_EQ(lines_of(folder / "run/drag.csv").size(), 1u + 4u);
}

TEST(StartFrom, SaysWhyItCannot) {
  const auto earlier = fresh_folder("earlier");
  OscillatorCase c{.steps = 4, .extra = "checkpoints { steps: 2 }"};
  write_case(earlier, c);
  ASSERT_EQ(run_coupler_with(earlier, {"run", "case.textproto"}), 0) << output(earlier);
  const auto refused = [&](const OscillatorCase& asked, const std::string& words) {
    const auto folder = fresh_folder("run");
    write_case(folder, asked);
    EXPECT_EQ(run_coupler_with(folder, {"run", "case.textproto"}), 2);
    EXPECT_NE(output(folder).find(words), std::string::npos) << output(folder);
  };
  c.extra += fmt::format(" start_from: '{}'", (earlier / "run").string());
  refused(c, "has done 4 steps already; time.steps, which counts them in, is 4");
  c.steps = 6;
  c.time_step = 0.01;
  refused(c, "its step is not the 0.01 of this case");
  c.extra = " start_from: 'nowhere'";
  refused(c, "nowhere holds no checkpoint");
}

TEST(Resume, CheckpointsNeedParticipantsThatCanGiveThem) {
  const auto folder = fresh_folder("run");
  write_case(folder, {.fluid_arguments = "--checkpoints no", .extra = "checkpoints { steps: 1 }"});
  EXPECT_EQ(run_coupler_with(folder, {"run", "case.textproto"}), 2);
  EXPECT_NE(output(folder).find("the case asks for checkpoints, but fluid cannot give one"),
            std::string::npos)
      << output(folder);
}

} // namespace
} // namespace drogue::test
