// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/check.hpp"

#include <chrono>
#include <cstdlib>

#include <unistd.h>

#include <fmt/format.h>

#include "coupler/launcher/process.hpp"

namespace drogue::coupler {
namespace {

constexpr auto check_deadline = std::chrono::minutes(2);

/// Runs "PROGRAM check CONFIG" and passes on every line it prints that reports an error.
void check_config(const ParticipantSettings& p, const std::filesystem::path& program,
                  config::Report& report) {
  std::string log = (std::filesystem::temp_directory_path() / "drogue-check-XXXXXX").string();
  const int descriptor = mkstemp(log.data());
  if (descriptor < 0) return report.error(p.config.string(), "no temporary file for its check");
  ::close(descriptor);
  launcher::Command command{{program.string(), "check", p.config.string()}, {}, p.config.parent_path(), log};
  auto process = launcher::Process::start(command);
  if (!process) {
    report.error(p.config.string(), process.error().message);
  } else if (const auto& exit = process->wait(check_deadline); !exit) {
    report.error(p.config.string(), fmt::format("{} check did not end", p.command));
  } else if (!exit->clean()) {
    std::size_t passed_on = 0;
    for (const std::string& line : launcher::last_lines(log, 1000)) {
      const std::size_t mark = line.find(": error: ");
      if (mark == std::string::npos) continue;
      report.error(line.substr(0, mark), line.substr(mark + 9));
      ++passed_on;
    }
    if (passed_on == 0) {
      const auto lines = launcher::last_lines(log, 1);
      report.error(p.config.string(), fmt::format("{} check {}: {}", p.command, exit->text(),
                                                  lines.empty() ? "it printed nothing" : lines[0]));
    }
  }
  std::error_code ignored;
  std::filesystem::remove(log, ignored);
}

} // namespace

void check_participants(const CaseSettings& settings, config::Report& report) {
  for (const ParticipantSettings* p : {&settings.fluid, &settings.structure, &settings.mesh_mover}) {
    const auto program = launcher::find_program(p->command);
    if (!program)
      report.error(settings.file.string(), fmt::format("{}.command: {}", p->name, program.error().message));
    else if (!p->config.empty())
      check_config(*p, *program, report);
  }
}

void check_case(const std::filesystem::path& file, config::Report& report) {
  const CaseSettings settings = load_case(file, report);
  if (!report.ok()) return;
  check_participants(settings, report);
}

} // namespace drogue::coupler
