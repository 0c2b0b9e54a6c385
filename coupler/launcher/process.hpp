// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <sys/types.h>

#include "common/base/result.hpp"

namespace drogue::launcher {

/// What to start: an argument list (no shell), extra environment, a working directory, and where its output
/// goes.
struct Command {
  std::vector<std::string> arguments;   ///< arguments[0] is the program, as found by find_program
  std::vector<std::string> environment; ///< NAME=value, added to the coupler's own
  std::filesystem::path directory;
  std::filesystem::path log_file; ///< receives standard output and standard error
};

/// How a process ended.
struct Exit {
  int status = 0; ///< exit status, when signal is 0
  int signal = 0;
  /// "exited with status 3", "was killed by signal 9 (Killed)".
  [[nodiscard]] std::string text() const;
  [[nodiscard]] bool clean() const { return status == 0 && signal == 0; }
};

/// A child process in a session of its own (signals for the coupler do not reach it; all its descendants can
/// be found), watched through a pidfd from its first instant. The destructor kills the whole session and
/// reaps.
class Process {
 public:
  /// Errors (ErrorKind::config): the program cannot be started, the log file cannot be written.
  [[nodiscard]] static Result<Process> start(const Command& command);
  Process(Process&& other) noexcept;
  Process& operator=(Process&& other) noexcept;
  ~Process();

  [[nodiscard]] pid_t pid() const { return pid_; }
  /// A descriptor that becomes readable when the process ends.
  [[nodiscard]] int pidfd() const { return pidfd_; }
  /// Reaps without waiting; the exit once the process has ended.
  [[nodiscard]] const std::optional<Exit>& poll();
  /// Waits for the end, at most `deadline`.
  [[nodiscard]] const std::optional<Exit>& wait(std::chrono::milliseconds deadline);
  /// SIGKILLs the process and everything it started, and reaps it.
  void kill_session();

 private:
  Process(pid_t pid, int pidfd) : pid_(pid), pidfd_(pidfd) {}
  pid_t pid_ = -1;
  int pidfd_ = -1;
  std::optional<Exit> exit_;
};

/// Watches a process that is not a child (an MPI rank under mpiexec).
class Watch {
 public:
  /// Nothing when there is no such process on this machine.
  [[nodiscard]] static std::optional<Watch> on(pid_t pid);
  Watch(Watch&& other) noexcept : pid_(other.pid_), pidfd_(std::exchange(other.pidfd_, -1)) {}
  Watch& operator=(Watch&& other) noexcept {
    std::swap(pid_, other.pid_);
    std::swap(pidfd_, other.pidfd_);
    return *this;
  }
  ~Watch();
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// A descriptor that becomes readable when the process ends.
  [[nodiscard]] int pidfd() const { return pidfd_; }
  [[nodiscard]] bool ended() const;

 private:
  Watch(pid_t pid, int pidfd) : pid_(pid), pidfd_(pidfd) {}
  pid_t pid_ = -1;
  int pidfd_ = -1;
};

/// The program called `name`: a path as it is (made absolute), else beside the coupler's own executable, else
/// in PATH. Errors (ErrorKind::config): not found; says where was looked.
[[nodiscard]] Result<std::filesystem::path> find_program(const std::string& name);

/// The most memory a running process has held [MB]; 0 when it is gone.
[[nodiscard]] double peak_memory_mb(pid_t pid);

/// The last `count` lines of a text file; empty when it cannot be read.
[[nodiscard]] std::vector<std::string> last_lines(const std::filesystem::path& file, std::size_t count);

} // namespace drogue::launcher
