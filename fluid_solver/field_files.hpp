// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "common/base/result.hpp"
#include "common/io/vtu.hpp"
#include "fluid_solver/averages.hpp"
#include "fluid_solver/flow_solver.hpp"

namespace drogue::fluid {

/// fluid.pvd and the fields it names: fluid_STEP.vtu, of several ranks fluid_STEP.pvtu with a piece of every
/// rank, piece_STEP_RANK.vtu: the cells whose first node is the rank's. The same object and calls on every
/// rank.
class FieldFiles {
 public:
  /// `settings` and `mesh` must outlive it; the folder must exist.
  FieldFiles(const Settings& settings, const FluidMesh& mesh, const std::filesystem::path& directory);

  /// Fields, when the step is due or `force` is set; never twice for a step, never with field_interval 0.
  /// Errors: a file cannot be written. @note Collective
  [[nodiscard]] Result<void> write(const FlowState& state, const FieldAverages& averages, bool force);
  /// The mesh has been replaced by another one.
  void take_mesh();
  /// Kept by rank 0.
  [[nodiscard]] io::PvdCollection& collection() { return collection_; }

 private:
  void choose_cells();
  [[nodiscard]] std::vector<double> values_of(std::span<const double> nodal, int components,
                                              double factor = 1) const;
  [[nodiscard]] Result<void> write_files(const FlowState& state, const FieldAverages& averages);

  const Settings* settings_;
  const FluidMesh* mesh_;
  std::filesystem::path directory_;
  io::PvdCollection collection_;
  std::optional<std::uint64_t> last_step_;
  std::vector<std::int32_t> nodes_;        ///< of this rank's piece, nodes of the mesh file in their order
  std::vector<mesh::ElementBlock> blocks_; ///< its cells, numbered by nodes_
};

} // namespace drogue::fluid
