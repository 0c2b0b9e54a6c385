// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <utility>

#include "common/base/result.hpp"

namespace drogue::coupler {

/// The folder of a run, held by this process alone: its file "lock" carries an flock, which the kernel
/// releases when the process ends, however it ends.
class RunDirectory {
 public:
  /// Makes the folder; results of an earlier run are moved aside to NAME.1, NAME.2, ...
  /// Errors (ErrorKind::config): another coupler runs there (named by its pid); it cannot be made or moved.
  [[nodiscard]] static Result<RunDirectory> create(const std::filesystem::path& wanted);
  /// Holds the folder of an earlier run, to continue it. Errors (ErrorKind::config): another coupler runs
  /// there; it is not the folder of a run.
  [[nodiscard]] static Result<RunDirectory> reopen(const std::filesystem::path& directory);
  /// Errors (ErrorKind::config): no coupler runs there.
  [[nodiscard]] static Result<void> check_running(const std::filesystem::path& directory);
  RunDirectory(RunDirectory&& other) noexcept
      : path_(std::move(other.path_)), lock_(std::exchange(other.lock_, -1)) {}
  RunDirectory& operator=(RunDirectory&&) = delete;
  ~RunDirectory();

  /// Absolute.
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  RunDirectory(std::filesystem::path path, int lock) : path_(std::move(path)), lock_(lock) {}
  [[nodiscard]] static Result<RunDirectory> hold(std::filesystem::path directory);
  std::filesystem::path path_;
  int lock_ = -1;
};

} // namespace drogue::coupler
