// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/io/state_file.hpp"
#include "mesh_mover/mover.hpp"

namespace drogue::mesh_mover {

/// A mesh that should take the place of the mover's.
struct Replacement {
  std::filesystem::path file;
  std::string mesh_hash;
  std::string reason;
};

/// Decides after a step whether the mesh is still good enough (Settings::remesh), and makes a new one
/// (common/meshing/remesh.hpp) if it is not, in which the elements near and beyond the limits are replaced.
class Remesher {
 public:
  /// @param program that knows the command "remesh": the mesh is made in a process of its own, as it must be
  /// for runs that
  ///        repeat to the bit; empty: in this one
  Remesher(const Settings& settings, std::filesystem::path program)
      : settings_(settings), program_(std::move(program)) {}

  /// The new mesh, in DIRECTORY/remesh_STEP.msh. A failure is logged; the old mesh then stays for some steps
  /// at least.
  [[nodiscard]] std::optional<Replacement> after_step(const MeshMover& mover, const Quality& quality,
                                                      std::uint64_t step,
                                                      const std::filesystem::path& directory);

  void save(io::State& state) const;
  void load(const io::State& state);

 private:
  [[nodiscard]] mesh::NodeField worn(const MeshMover& mover) const;
  [[nodiscard]] Limits limits(const MeshMover& mover) const;
  [[nodiscard]] Result<mesh::Mesh> make(const MeshMover& mover, const std::filesystem::path& file) const;

  const Settings& settings_;
  std::filesystem::path program_;
  std::uint64_t not_before_ = 0; ///< step, after a failure
};

/// A mesh and the mover on it, in the place of one that moves by the same settings. Errors
/// (ErrorKind::config): the file cannot be read, or holds another mesh than that of the hash.
[[nodiscard]] Result<std::unique_ptr<MeshMover>>
mover_on(const std::filesystem::path& file, const std::string& mesh_hash, const Settings& settings);

} // namespace drogue::mesh_mover
