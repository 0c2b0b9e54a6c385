// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "common/io/csv.hpp"
#include "common/io/vtu.hpp"
#include "mesh_mover/mover.hpp"

namespace drogue::mesh_mover {

/// Writes mesh.csv (a row a step: iterations, volumes, mean ratios, f_A and f_AR, angles, and where the worst
/// element is), warns of meshes beyond Settings::warn, and writes mesh.pvd with mesh_NNNNNN.vtu: the moved
/// mesh with its displacement, and volume ratio and mean ratio of every element.
class Results {
 public:
  Results() = default;
  /// Creates the folder and starts the files. Errors: it cannot be written.
  [[nodiscard]] static Result<Results> create(const OutputSettings& settings,
                                              io::Existing existing = io::Existing::replace);

  /// What the last committed step looks like; `is_last` writes the fields whatever the interval says.
  [[nodiscard]] Result<void> write(const MeshMover& mover, std::uint64_t step, double time,
                                   const SolveReport& report, bool is_last);

  /// How far the files are written: noted for a checkpoint, and gone back to.
  [[nodiscard]] Result<void> save_positions(const std::filesystem::path& file);
  [[nodiscard]] Result<void> restore_positions(const std::filesystem::path& file);

 private:
  [[nodiscard]] Result<void> write_fields(const MeshMover& mover, std::uint64_t step, double time);

  OutputSettings settings_;
  io::CsvWriter series_;
  io::PvdCollection collection_;
};

} // namespace drogue::mesh_mover
