// SPDX-License-Identifier: GPL-3.0-or-later
// Participants that somebody starts by hand, with the command that the coupler prints: over TCP, with CURVE
// keys and without. The run is the oscillator's, and its results those of a run whose participants are all
// the coupler's children. tests/support/network_namespaces does the same between two hosts.
#include <csignal>
#include <regex>

#include "participant/cpp/keys.hpp"
#include "tests/support/checkpoint_runs.hpp"
#include "tests/support/processes.hpp"

namespace drogue::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr const char* python_mover = DROGUE_SOURCE_DIR "/tests/support/surface_mover.py";

std::string by_hand(const std::string& role, const std::string& program, const std::string& more = "") {
  return fmt::format("{} {{ command: '{}' argument: '{}' launch: NONE {} }}\n", role, program, role, more);
}

std::string oscillator() {
  return std::string(DROGUE_TEST_BIN_DIR) + "/oscillator_participant";
}

/// The oscillator's case, with `participant` in the place of the one of that role.
void write_remote_case(const fs::path& folder,
                       const std::vector<std::pair<std::string, std::string>>& participants,
                       const std::string& extra, int steps = 5) {
  const auto file = write_case(folder, {.steps = steps, .extra = extra + " deadlines { by_hand: 60 }"});
  std::string text = read_text(file);
  for (const auto& [role, participant] : participants) {
    const std::string child = participant_text(role, "");
    text.replace(text.find(child), child.size(), participant);
  }
  std::ofstream(file) << text;
}

class Remote : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder("run");
    const auto undisturbed = fresh_folder("undisturbed");
    write_case(undisturbed, {});
    ASSERT_EQ(run_coupler_with(undisturbed, {"run", "case.textproto"}), 0);
    expected_ = read_text(undisturbed / "run/drag.csv");
  }
  void start_coupler() { coupler_.emplace(start_program(folder_, {"run", "case.textproto"})); }
  void make_keys(const std::vector<std::string>& names) {
    std::vector<std::string> command{"keygen"};
    command.insert(command.end(), names.begin(), names.end());
    ASSERT_EQ(run_coupler_with(folder_, command), 0) << output();
  }
  [[nodiscard]] std::string output() const { return read_text(folder_ / "output.txt"); }
  /// The printed line that starts a participant.
  std::string command_for(const std::string& role) {
    const std::regex line("^env .*DROGUE_PARTICIPANT=" + role + " .*$", std::regex::multiline);
    std::smatch match;
    std::string text;
    EXPECT_TRUE(eventually([&] { return text = output(), std::regex_search(text, match, line); })) << text;
    return match.str();
  }
  launcher::Process start_by_hand(const std::string& line, const std::string& log = "by_hand.txt") {
    auto process = launcher::Process::start({{"/bin/sh", "-c", "exec " + line}, {}, folder_, folder_ / log});
    EXPECT_TRUE(process.ok());
    return std::move(*process);
  }
  static int status_of(launcher::Process& process) {
    const auto& exit = process.wait(30s);
    return exit ? exit->status : -1;
  }
  void expect_undisturbed_results() {
    EXPECT_EQ(status_of(*coupler_), 0) << output();
    EXPECT_EQ(read_text(folder_ / "run/drag.csv"), expected_);
  }
  static std::string replaced(std::string line, const std::string& pattern, const std::string& by) {
    return std::regex_replace(line, std::regex(pattern), by);
  }

  fs::path folder_;
  std::string expected_;
  std::optional<launcher::Process> coupler_;
};

TEST_F(Remote, ASolverStartedByHandOnThisMachineNeedsNoKey) {
  write_remote_case(folder_, {{"fluid", by_hand("fluid", oscillator())}}, "");
  start_coupler();
  launcher::Process fluid = start_by_hand(command_for("fluid"));
  expect_undisturbed_results();
  EXPECT_EQ(status_of(fluid), 0);
}

constexpr const char* with_keys = "network { endpoint: 'tcp://127.0.0.1:*' key: 'coupler.key' }";

TEST_F(Remote, OnlyAllowedKeysAreLetIn) {
  make_keys({"coupler", "fluid", "mesh_mover", "stranger"});
  write_remote_case(
      folder_,
      {{"fluid", by_hand("fluid", oscillator(), "public_key: 'fluid.pub'")},
       {"mesh_mover",
        by_hand("mesh_mover", python_mover,
                "public_key: 'mesh_mover.pub' environment: 'PYTHONPATH=" DROGUE_PYTHON_DIR "'")}},
      with_keys);
  start_coupler();
  const std::string fluid_line = command_for("fluid"), mover_line = command_for("mesh_mover");

  launcher::Process stranger =
      start_by_hand(replaced(fluid_line, "fluid.key", "stranger.key"), "stranger.txt");
  EXPECT_EQ(status_of(stranger), 4);
  EXPECT_NE(read_text(folder_ / "stranger.txt").find("the coupler does not allow this participant's key"),
            std::string::npos)
      << read_text(folder_ / "stranger.txt");
  launcher::Process pythonic =
      start_by_hand(replaced(mover_line, "mesh_mover.key", "stranger.key"), "pythonic.txt");
  EXPECT_EQ(status_of(pythonic), 4);
  EXPECT_NE(read_text(folder_ / "pythonic.txt").find("the coupler does not allow this participant's key"),
            std::string::npos)
      << read_text(folder_ / "pythonic.txt");
  launcher::Process keyless =
      start_by_hand(replaced(fluid_line, "DROGUE_(COUPLER_)?KEY=", "NO_KEY="), "keyless.txt");
  EXPECT_EQ(status_of(keyless), 4);
  // The key of one participant does not open the door to another's place.
  launcher::Process pretender =
      start_by_hand(replaced(fluid_line, "fluid.key", "mesh_mover.key"), "pretender.txt");
  EXPECT_TRUE(eventually([&] { return output().find("calls himself \"fluid\"") != std::string::npos; }))
      << output();
  pretender.kill_session();

  EXPECT_FALSE(coupler_->poll().has_value()) << output();
  launcher::Process fluid = start_by_hand(fluid_line), mover = start_by_hand(mover_line);
  expect_undisturbed_results();
  EXPECT_EQ(status_of(fluid), 0) << read_text(folder_ / "by_hand.txt");
  EXPECT_EQ(status_of(mover), 0) << read_text(folder_ / "by_hand.txt");
}

TEST_F(Remote, AWrongCouplerIsNotTrusted) {
  make_keys({"coupler", "fluid", "another"});
  write_remote_case(folder_, {{"fluid", by_hand("fluid", oscillator(), "public_key: 'fluid.pub'")}},
                    with_keys);
  start_coupler();
  const auto another = keys::read_public(folder_ / "another.pub"),
             right = keys::read_public(folder_ / "coupler.pub");
  ASSERT_TRUE(another.ok() && right.ok());
  std::string line = command_for("fluid");
  line.replace(line.find(*right), right->size(), *another);
  launcher::Process fluid = start_by_hand(line);
  EXPECT_EQ(status_of(fluid), 4) << read_text(folder_ / "by_hand.txt");
  coupler_->kill_session();
}

TEST_F(Remote, WithoutKeysNoOtherMachineIsSpokenTo) {
  for (const std::string& program :
       {oscillator() + " fluid", "env PYTHONPATH=" DROGUE_PYTHON_DIR " " + std::string(python_mover)}) {
    fs::remove(folder_ / "by_hand.txt");
    launcher::Process process =
        start_by_hand("env DROGUE_PARTICIPANT=fluid " + program + " --connect tcp://192.0.2.1:5555");
    EXPECT_EQ(status_of(process), 2);
    EXPECT_NE(read_text(folder_ / "by_hand.txt").find("is not on this machine, and there are no keys"),
              std::string::npos)
        << read_text(folder_ / "by_hand.txt");
  }
}

TEST_F(Remote, TheDeathOfASolverStartedByHandIsNoticed) {
  write_remote_case(
      folder_, {{"fluid", by_hand("fluid", oscillator(), "argument: '--delay' argument: '0.2'")}}, "", 1000);
  start_coupler();
  launcher::Process fluid = start_by_hand(command_for("fluid"));
  EXPECT_TRUE(eventually([&] { return output().find("step 1/") != std::string::npos; })) << output();
  kill(fluid.pid(), SIGKILL);
  EXPECT_EQ(status_of(*coupler_), 4);
  EXPECT_NE(output().find("fluid (started by hand) closed its connection"), std::string::npos) << output();
  EXPECT_EQ(left_behind(folder_), 0);
}

TEST_F(Remote, APortThatIsTakenIsNamed) {
  zmq::context_t context;
  zmq::socket_t taken(context, zmq::socket_type::router);
  taken.bind("tcp://127.0.0.1:*");
  const std::string endpoint = taken.get(zmq::sockopt::last_endpoint);
  write_remote_case(folder_, {{"fluid", by_hand("fluid", oscillator())}},
                    fmt::format("network {{ endpoint: '{}' }}", endpoint));
  start_coupler();
  EXPECT_EQ(status_of(*coupler_), 2);
  EXPECT_NE(output().find(fmt::format("cannot listen at {}: Address already in use", endpoint)),
            std::string::npos)
      << output();
  EXPECT_EQ(left_behind(folder_), 0);
}

TEST_F(Remote, KeysAreNeverWrittenOverAndKeptFromOthers) {
  make_keys({"fluid"});
  EXPECT_EQ(fs::status(folder_ / "fluid.key").permissions(), fs::perms::owner_read | fs::perms::owner_write);
  const std::string before = read_text(folder_ / "fluid.key");
  EXPECT_EQ(run_coupler_with(folder_, {"keygen", "fluid"}), 2);
  EXPECT_EQ(read_text(folder_ / "fluid.key"), before);
}

} // namespace
} // namespace drogue::test
