// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/participant_command.hpp"

#include <algorithm>
#include <cstdlib>

#include "common/base/worker_pool.hpp"
#include "coupler/launcher/process.hpp"

namespace drogue::coupler {

std::vector<std::string> participant_environment(const ParticipantSettings& p) {
  std::vector<std::string> e{"DROGUE_PARTICIPANT=" + p.name};
  const auto given = [&](const std::string& name) {
    return std::getenv(name.c_str()) ||
           std::any_of(p.environment.begin(), p.environment.end(),
                       [&](const auto& own) { return own.rfind(name + "=", 0) == 0; });
  };
  // Where ranks share processors, one that waits for another must leave it its own. Elsewhere it would leave
  // it to whatever else the machine does, and get it back late.
  const bool ranks_share = p.ranks > usable_processors();
  for (const std::string& preset :
       {std::string("OPENBLAS_NUM_THREADS=1"), std::string("OMP_NUM_THREADS=1"),
        std::string("OMPI_ALLOW_RUN_AS_ROOT=1"), std::string("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1"),
        fmt::format("OMPI_MCA_mpi_yield_when_idle={}", ranks_share ? 1 : 0)})
    if (!given(preset.substr(0, preset.find('=')))) e.push_back(preset);
  e.insert(e.end(), p.environment.begin(), p.environment.end());
  return e;
}

Result<std::vector<std::string>> run_command(const ParticipantSettings& p, const std::string& endpoint) {
  const auto find = [&](const std::string& name) -> Result<std::string> {
    if (p.by_hand) return name;
    const auto program = launcher::find_program(name);
    if (!program) return Error{ErrorKind::config, fmt::format("{}: {}", p.name, program.error().message)};
    return program->string();
  };
  const auto program = find(p.command);
  if (!program) return program.error();
  std::vector<std::string> a;
  if (p.ranks > 1) {
    const auto mpiexec = find("mpiexec");
    if (!mpiexec) return mpiexec.error();
    a = {*mpiexec, "-n", std::to_string(p.ranks), "--oversubscribe", "--bind-to", "none"};
  }
  a.push_back(*program);
  if (!p.config.empty()) a.insert(a.end(), {"run", p.config.string()});
  a.insert(a.end(), p.arguments.begin(), p.arguments.end());
  a.insert(a.end(), {"--connect", endpoint});
  return a;
}

std::string shell_line(const std::vector<std::string>& environment,
                       const std::vector<std::string>& arguments) {
  constexpr const char* plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%";
  std::string line = "env";
  for (const auto* words : {&environment, &arguments})
    for (const std::string& word : *words) {
      std::string quoted = word;
      for (std::size_t at = quoted.find('\''); at != std::string::npos; at = quoted.find('\'', at + 4))
        quoted.replace(at, 1, "'\\''");
      const bool is_plain = !word.empty() && word.find_first_not_of(plain) == std::string::npos;
      line += is_plain ? " " + word : " '" + quoted + "'";
    }
  return line;
}

} // namespace drogue::coupler
