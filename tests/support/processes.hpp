// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <csignal>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <sys/types.h>

/// What tests see of the processes on this machine, and do to them.
namespace drogue::test {

/// Processes on this machine.
inline std::vector<pid_t> all_pids() {
  std::vector<pid_t> pids;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") == std::string::npos) pids.push_back(std::stoi(name));
  }
  return pids;
}

/// Living children of a process; those that ended and were not waited for do not count.
inline std::vector<pid_t> children_of(pid_t parent) {
  std::vector<pid_t> children;
  for (const pid_t pid : all_pids()) {
    std::string text;
    std::getline(std::ifstream("/proc/" + std::to_string(pid) + "/stat"), text);
    const std::size_t name_end = text.rfind(')');
    if (name_end == std::string::npos) continue;
    std::istringstream rest(text.substr(name_end + 1));
    char state = 0;
    pid_t its_parent = 0;
    if (rest >> state >> its_parent && its_parent == parent && state != 'Z') children.push_back(pid);
  }
  return children;
}

/// Whether a process works in a folder or below.
inline bool works_in(pid_t pid, const std::filesystem::path& folder) {
  std::error_code failure;
  const auto cwd = std::filesystem::read_symlink("/proc/" + std::to_string(pid) + "/cwd", failure);
  return !failure && cwd.string().rfind(folder.string(), 0) == 0;
}

/// Processes that still belong to the run in `folder`: their working directory lies in folder/run.
inline int left_behind(const std::filesystem::path& folder) {
  int count = 0;
  for (const pid_t pid : all_pids()) count += works_in(pid, folder / "run") ? 1 : 0;
  return count;
}

/// SIGKILLs one participant of the coupler `parent`, whose run is in folder/run, picked by `random`. False:
/// it has none. (Other children of the coupler are programs that check a config.)
inline bool kill_a_participant(pid_t parent, const std::filesystem::path& folder, std::mt19937& random) {
  auto victims = children_of(parent);
  std::erase_if(victims, [&](pid_t pid) { return !works_in(pid, folder / "run"); });
  return !victims.empty() && kill(victims[random() % victims.size()], SIGKILL) == 0;
}

} // namespace drogue::test
