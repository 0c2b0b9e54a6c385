// SPDX-License-Identifier: GPL-3.0-or-later
// Every fault of fault_matrix.hpp: the run ends with the right status, names the culprit, in time, and leaves
// no process; what was written stays, and a run with a checkpoint goes on from there to the undisturbed
// results. Environment: DROGUE_FAULTS, a regular expression, picks cases by their name VICTIM_FAULT_REQUEST.
#include "tests/faults/fault_matrix.hpp"

#include <cstdlib>
#include <regex>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/support/checkpoint_runs.hpp"
#include "tests/support/processes.hpp"
#include "tests/support/verify.hpp"

namespace drogue::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;
using Files = std::map<std::string, std::string>;

constexpr int steps = 6;
constexpr double deadline = 2;
constexpr double grace_of_participants = 11; ///< after the death of the coupler
constexpr const char* settings = "checkpoints { steps: 2 keep: 9 }"
                                 "deadlines { connect: 3 initialize: 2 iterate: 2 other: 2 shutdown: 2 }";

struct Figures {
  int cases = 0, right = 0, in_time = 0, orphans = 0, lost = 0;
};

/// The program of the victim in the case, in place of the oscillator's.
std::string spoiled(const FaultCase& f, const std::string& role) {
  const std::string program = std::string(DROGUE_TEST_BIN_DIR) + "/oscillator_participant";
  std::vector<std::string> words;
  if (f.fault == "PORT")
    return fmt::format("{} {{ command: '{}' argument: '{}' launch: NONE }}\n", role, program, role);
  if (f.fault == "ANOTHER_ROLE")
    words = {"env", std::string("DROGUE_PARTICIPANT=") + (role == "fluid" ? "structure" : "fluid"), program,
             role};
  else if (f.by_proxy)
    words = {std::string(DROGUE_TEST_BIN_DIR) + "/flaky_proxy", f.fault, f.at, program, role};
  else
    words = {program, role, "--fault", f.fault, "--at", f.at};
  std::string text = fmt::format("{} {{ command: '{}'", role, words[0]);
  for (std::size_t i = 1; i < words.size(); ++i) text += fmt::format(" argument: '{}'", words[i]);
  return text + " }\n";
}

/// A TCP port of the loopback that somebody else listens at.
class TakenPort {
 public:
  TakenPort() : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    EXPECT_TRUE(bind(socket_, any, size) == 0 && listen(socket_, 1) == 0 &&
                getsockname(socket_, any, &size) == 0);
    number_ = ntohs(address.sin_port);
  }
  ~TakenPort() { close(socket_); }
  TakenPort(const TakenPort&) = delete;
  TakenPort& operator=(const TakenPort&) = delete;
  [[nodiscard]] int number() const { return number_; }

 private:
  int socket_, number_ = 0;
};

void write_spoiled_case(const fs::path& folder, const FaultCase& f, const TakenPort& taken) {
  const auto file = write_case(folder, {.steps = steps, .extra = settings});
  const std::string role = f.victim == "coupler" ? "structure" : f.victim,
                    healthy = participant_text(role, "");
  std::string text = read_text(file);
  text.replace(text.find(healthy), healthy.size(), spoiled(f, role));
  if (f.fault == "PORT")
    text += fmt::format("network {{ endpoint: 'tcp://127.0.0.1:{}' }}\n", taken.number());
  std::ofstream(file) << text;
}

launcher::Process start(const fs::path& folder, const FaultCase& f) {
  std::vector<std::string> environment;
  if (f.fault == "SOCKET") {
    const fs::path far = folder / std::string(120, 'x'); // too long for a socket's path
    fs::create_directories(far);
    environment.push_back("TMPDIR=" + far.string());
  }
  auto process =
      launcher::Process::start({{std::string(DROGUE_BIN_DIR) + "/coupler", "run", "case.textproto"},
                                environment,
                                folder,
                                folder / "output.txt"});
  EXPECT_TRUE(process.ok());
  return std::move(*process);
}

/// Lines of a file that another does not begin with.
bool is_start_of(const std::string& part, const std::string& whole) {
  return whole.compare(0, part.size(), part) == 0;
}

int lines(const std::string& text) {
  return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}

/// What is written is the start of the undisturbed results, as far as it was committed for sure; and a run
/// with a checkpoint ends, when it is resumed without the fault, as the undisturbed one. @return what is
/// wrong
std::string loss(const fs::path& folder, const FaultCase& f, int status, const Files& undisturbed) {
  const auto differing = [&]() -> std::string {
    for (const auto& [name, text] : everything(folder, steps))
      if (!undisturbed.count(name) || undisturbed.at(name) != text) return name + " differs";
    return everything(folder, steps).size() == undisturbed.size() ? "" : "a file is missing";
  };
  if (status == 0) return differing();
  const std::string drag = read_text(folder / "run/drag.csv");
  const bool late = f.at == "BeginStep" || f.at == "Iterate" || f.at == "Commit" || f.at == "Checkpoint";
  const int sure = f.at == "Shutdown" || f.at == "destructor" ? steps : late ? 2 : 0;
  if (sure > 0 && (lines(drag) < 1 + sure || !is_start_of(drag, undisturbed.at("drag.csv"))))
    return "drag.csv lost steps";
  if (!has_checkpoint(folder, 2)) return sure > 0 ? "there is no checkpoint" : "";
  write_case(folder, {.steps = steps, .extra = settings});
  const int resumed = run_coupler_with(folder, {"resume", "run", "--accept-changes"});
  return resumed == 0 ? differing() : fmt::format("resume ended with status {}", resumed);
}

void judge(const FaultCase& f, const Files& undisturbed, double normal, Figures& figures) {
  const auto folder = fresh_folder(f.name());
  const TakenPort taken;
  write_spoiled_case(folder, f, taken);
  const auto begin = Clock::now();
  launcher::Process coupler = start(folder, f);
  const auto& exit = coupler.wait(std::chrono::seconds(60));
  const double took = Seconds(Clock::now() - begin).count();
  const int status = !exit ? 1000 : exit->signal != 0 ? -exit->signal : exit->status;
  const std::string text = read_text(folder / "output.txt");

  ++figures.cases;
  const bool right = status == f.status && std::regex_search(text, std::regex(f.culprit));
  figures.right += right ? 1 : 0;
  EXPECT_TRUE(right) << f.name() << ": status " << status << " (expected " << f.status << "), culprit /"
                     << f.culprit << "/ in\n"
                     << text;
  const double limit = 3 * normal + deadline + 2 + (f.at == "Hello" ? 1 : 0); // connect: 3
  figures.in_time += took <= limit ? 1 : 0;
  EXPECT_LE(took, limit) << f.name();
  const double patience = f.status < 0 ? grace_of_participants : 0.5;
  const bool clean = eventually([&] { return left_behind(folder) == 0; }, patience);
  figures.orphans += clean ? 0 : left_behind(folder);
  EXPECT_TRUE(clean) << f.name() << " leaves processes";
  const std::string lost = f.at == "start" ? "" : loss(folder, f, status, undisturbed);
  figures.lost += lost.empty() ? 0 : 1;
  EXPECT_EQ(lost, "") << f.name() << ": " << read_text(folder / "output.txt");
}

std::vector<FaultCase> selected() {
  const char* wanted = std::getenv("DROGUE_FAULTS");
  std::vector<FaultCase> cases;
  int number = 0;
  for (const FaultCase& f : fault_matrix())
    if (wanted ? std::regex_search(f.name(), std::regex(wanted)) : number++ % DROGUE_EVERY == 0)
      cases.push_back(f);
  return cases;
}

TEST(FaultMatrix, EndsAsItShould) {
  const auto folder = fresh_folder("undisturbed");
  write_case(folder, {.steps = steps, .extra = settings});
  const auto begin = Clock::now();
  ASSERT_EQ(run_coupler_with(folder, {"run", "case.textproto"}), 0) << read_text(folder / "output.txt");
  const double normal = Seconds(Clock::now() - begin).count();
  const Files undisturbed = everything(folder, steps);
  Figures figures;
  const auto cases = selected();
  for (const FaultCase& f : cases) judge(f, undisturbed, normal, figures);
  const std::string name = "participants/fault_matrix";
  verify(name, "cases", figures.cases, static_cast<double>(cases.size()), 0);
  verify(name, "right_status_and_culprit", figures.right, figures.cases, 0);
  verify(name, "within_deadline_and_2_s", figures.in_time, figures.cases, 0);
  verify(name, "orphans", figures.orphans, 0, 0);
  verify(name, "results_lost", figures.lost, 0, 0);
}

} // namespace
} // namespace drogue::test
