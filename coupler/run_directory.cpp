// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/run_directory.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <unistd.h>

namespace drogue::coupler {
namespace {

namespace fs = std::filesystem;

constexpr const char* lock_file = "lock";

/// The descriptor that holds the lock of a folder.
Result<int> take_lock(const fs::path& directory) {
  const fs::path file = directory / lock_file;
  const int lock = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock < 0) return config_error("cannot write {}: {}", file.string(), std::strerror(errno));
  if (flock(lock, LOCK_EX | LOCK_NB) == 0) return lock;
  const int reason = errno;
  close(lock);
  if (reason != EWOULDBLOCK) return config_error("cannot lock {}: {}", file.string(), std::strerror(reason));
  std::string pid;
  std::getline(std::ifstream(file), pid);
  return config_error(
      "another coupler{} runs in {}: wait for its end, or give this run a run_directory of its "
      "own",
      pid.empty() ? "" : fmt::format(" (pid {})", pid), directory.string());
}

Result<void> move_aside(const fs::path& directory) {
  fs::path aside;
  for (int i = 1; aside.empty() || fs::exists(aside); ++i) aside = directory.string() + fmt::format(".{}", i);
  std::error_code failure;
  fs::rename(directory, aside, failure);
  if (failure) return config_error("cannot move {} aside: {}", directory.string(), failure.message());
  spdlog::info("the results of an earlier run are kept in {}", aside.string());
  return {};
}

} // namespace

Result<RunDirectory> RunDirectory::create(const fs::path& wanted) {
  fs::path directory = fs::absolute(wanted).lexically_normal();
  if (!directory.has_filename()) directory = directory.parent_path(); // "out/"
  std::error_code failure;
  if (fs::exists(directory) && !fs::is_empty(directory, failure)) {
    const auto old = take_lock(directory); // nobody may be at work in what is moved
    if (!old) return old.error();
    const auto moved = move_aside(directory);
    close(*old);
    if (!moved) return moved.error();
  }
  fs::create_directories(directory, failure);
  if (failure)
    return config_error("cannot make the run directory {}: {}", directory.string(), failure.message());
  return hold(std::move(directory));
}

Result<RunDirectory> RunDirectory::reopen(const fs::path& directory) {
  if (!fs::exists(directory / lock_file))
    return config_error("{} is not the folder of a run: it has no file \"{}\"", directory.string(),
                        lock_file);
  return hold(fs::absolute(directory).lexically_normal());
}

Result<void> RunDirectory::check_running(const fs::path& directory) {
  const int lock = open((directory / lock_file).c_str(), O_RDONLY | O_CLOEXEC);
  const bool held = lock >= 0 && flock(lock, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  if (lock >= 0) close(lock);
  return held ? Result<void>() : config_error("no coupler runs in {}", directory.string());
}

/// Takes the lock and leaves the pid in it.
Result<RunDirectory> RunDirectory::hold(fs::path directory) {
  const auto lock = take_lock(directory);
  if (!lock) return lock.error();
  const std::string pid = fmt::format("{}\n", getpid());
  if (ftruncate(*lock, 0) != 0 || write(*lock, pid.data(), pid.size()) != static_cast<ssize_t>(pid.size())) {
    const int reason = errno;
    close(*lock);
    return config_error("cannot write into {}: {}", directory.string(), std::strerror(reason));
  }
  return RunDirectory(std::move(directory), *lock);
}

RunDirectory::~RunDirectory() {
  if (lock_ >= 0) close(lock_);
}

} // namespace drogue::coupler
