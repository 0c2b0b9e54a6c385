// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.hpp"

namespace drogue::coupler {

/// A file the run depends on, and what it held.
struct Input {
  std::filesystem::path path;
  std::string hash;
  bool operator==(const Input&) const = default;
};

/// A mesh that has taken the place of another one.
struct MeshFile {
  std::filesystem::path path; ///< absolute
  std::string mesh_hash;
};

/// What a manifest says, see proto/drogue/v1/checkpoint.proto.
struct Manifest {
  std::uint64_t step = 0;
  double time = 0;
  Input case_file;
  std::vector<Input> inputs;
  std::optional<MeshFile> mesh = {}; ///< in the place of the configs' mesh
};

/// The folder of a run's checkpoints: RUN/checkpoints/STEP with a folder for each participant, the coupler's
/// own state, and, written last, manifest.textproto with size and checksum of every file.
class CheckpointStore {
 public:
  explicit CheckpointStore(const std::filesystem::path& run_directory)
      : root_(run_directory / "checkpoints") {}

  [[nodiscard]] std::filesystem::path folder(std::uint64_t step) const;
  /// Steps of the complete checkpoints (those with a manifest), ascending.
  [[nodiscard]] std::vector<std::uint64_t> steps() const;
  /// An empty folder; whatever stood there is removed.
  [[nodiscard]] Result<std::filesystem::path> begin(std::uint64_t step) const;
  /// Brings every file of the folder onto the disk and writes the manifest. Errors: ErrorKind::internal.
  [[nodiscard]] Result<void> complete(const Manifest& manifest) const;
  /// Reads a manifest and compares every file with it. Errors (ErrorKind::config): what is missing, cut short
  /// or altered.
  [[nodiscard]] Result<Manifest> read(std::uint64_t step) const;
  /// The newest checkpoint that is whole, not after the step `wanted`, whose checkpoint must be there; logs
  /// why others are not used. Errors (ErrorKind::config): there is none.
  [[nodiscard]] Result<Manifest> newest_whole(const std::optional<std::uint64_t>& wanted = {}) const;
  /// Removes all but the newest `keep` complete ones, and what was never completed before the newest.
  void prune(int keep) const;
  /// Removes the checkpoints after `step`.
  void drop_after(std::uint64_t step) const;

 private:
  /// All folders, complete or not, ascending.
  [[nodiscard]] std::vector<std::uint64_t> folders() const;
  [[nodiscard]] bool is_complete(std::uint64_t step) const;
  void remove(std::uint64_t step) const;

  std::filesystem::path root_;
};

} // namespace drogue::coupler
