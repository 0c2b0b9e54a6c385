// SPDX-License-Identifier: GPL-3.0-or-later
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/mesh/msh.hpp"
#include "common/meshing/remesh.hpp"

namespace drogue::meshing {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

/// Starts the program and waits for its end; what it prints lands in `log`. Returns the status of waitpid.
Result<int> run_program(std::vector<std::string> arguments, const fs::path& log) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, log.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0644);
  posix_spawn_file_actions_adddup2(&files, STDERR_FILENO, STDOUT_FILENO);
  pid_t pid = -1;
  const int failure = posix_spawn(&pid, argv[0], &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (failure != 0) return internal_error("cannot start {}: {}", arguments[0], std::strerror(failure));
  int status = 0;
  while (waitpid(pid, &status, 0) < 0)
    if (errno != EINTR)
      return internal_error("lost the process of {}: {}", arguments[0], std::strerror(errno));
  return status;
}

} // namespace

Result<mesh::Mesh> remesh_in_process(const fs::path& program, const mesh::Mesh& old, const fs::path& to) {
  const fs::path before = to.string() + ".before", log = to.string() + ".log";
  DROGUE_TRY(mesh::write_msh(before, old));
  const auto status = run_program({program.string(), "remesh", before.string(), to.string()}, log);
  if (!status) return status.error();
  const std::string said = text_of(log);
  std::error_code ignored;
  fs::remove(log, ignored);
  if (!WIFEXITED(*status) || WEXITSTATUS(*status) != 0)
    return numerical_error("{} cannot be meshed anew: {}", before.string(),
                           said.empty() ? "the process that tried was killed" : said);
  fs::remove(before, ignored);
  return mesh::read_msh(to);
}

} // namespace drogue::meshing
