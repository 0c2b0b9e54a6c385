// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/check.hpp"

#include <chrono>
#include <cstdlib>

#include <fmt/format.h>

#include "coupler/launcher/process.hpp"
#include "coupler/participant_command.hpp"

namespace drogue::coupler {
namespace {

constexpr auto check_deadline = std::chrono::minutes(2);

/// An empty folder of its own, as a participant finds one at launch; removed with all that is in it.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "drogue-check-XXXXXX").string();
    if (mkdtemp(name.data())) path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Passes on every line of a failed check that reports an error; its last line when none does.
void pass_on(const ParticipantSettings& p, const std::filesystem::path& log, const launcher::Exit& exit,
             config::Report& report) {
  std::size_t passed_on = 0;
  for (const std::string& line : launcher::last_lines(log, 1000)) {
    const std::size_t mark = line.find(": error: ");
    if (mark == std::string::npos) continue;
    report.error(line.substr(0, mark), line.substr(mark + 9));
    ++passed_on;
  }
  if (passed_on > 0) return;
  const auto lines = launcher::last_lines(log, 1);
  report.error(p.config.string(), fmt::format("{} check {}: {}", p.command, exit.text(),
                                              lines.empty() ? "it printed nothing" : lines[0]));
}

/// Runs "PROGRAM check CONFIG" with the environment of a run: DROGUE_PARTICIPANT there asks for the check of
/// a participant, and a program that does not know the variable checks what it can.
void check_config(const ParticipantSettings& p, const std::filesystem::path& program,
                  config::Report& report) {
  const ScratchFolder folder;
  if (folder.path().empty()) return report.error(p.config.string(), "no temporary folder for its check");
  launcher::Command command{
      {program.string(), "check", p.config.string()}, participant_environment(p), folder.path() / "work", {}};
  command.environment.emplace_back("OMPI_MCA_ess_singleton_isolated=1"); // one process, without mpiexec
  command.log_file = folder.path() / "check.log";
  std::error_code failure;
  std::filesystem::create_directory(command.directory, failure);
  auto process = launcher::Process::start(command);
  if (!process)
    report.error(p.config.string(), process.error().message);
  else if (const auto& exit = process->wait(check_deadline); !exit)
    report.error(p.config.string(), fmt::format("{} check did not end", p.command));
  else if (!exit->clean())
    pass_on(p, command.log_file, *exit, report);
}

void check_participants(const CaseSettings& settings, config::Report& report) {
  for (const ParticipantSettings* p : participants_of(settings)) {
    if (p->command.empty() || p->by_hand) continue; // reported as missing; perhaps of another machine
    const auto program = launcher::find_program(p->command);
    if (!program)
      report.error(p->command_position, fmt::format("{}.command: {}", p->name, program.error().message));
    else if (std::filesystem::is_regular_file(p->config))
      check_config(*p, *program, report);
  }
}

} // namespace

CaseSettings check_case(const std::filesystem::path& file, config::Report& report) {
  CaseSettings settings = load_case(file, report);
  check_participants(settings, report);
  return settings;
}

} // namespace drogue::coupler
