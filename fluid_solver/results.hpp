// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "common/base/result.hpp"
#include "common/io/csv.hpp"
#include "common/io/positions.hpp"
#include "common/io/vtu.hpp"
#include "fluid_solver/averages.hpp"
#include "fluid_solver/flow_solver.hpp"
#include "fluid_solver/forces.hpp"
#include "fluid_solver/probes.hpp"

namespace drogue::fluid {

/// Figures of a step besides the fields.
struct StepFigures {
  NewtonReport newton;
  double cfl = 0;
  double mass_imbalance = 0;
  std::vector<SurfaceForce> forces;
};

/// All files of a run: fluid.pvd with fluid_*.vtu, flow.csv, forces.csv, probes.csv,
/// averages.csv. Used on rank 0 only.
class Results {
 public:
  [[nodiscard]] static Result<Results> create(const Settings& settings, const FluidMesh& mesh,
                                              const std::filesystem::path& directory,
                                              io::Existing existing = io::Existing::replace);
  /// The probes' values, and a row of the other series when the step is due.
  [[nodiscard]] Result<void> write_series(const FlowState& state, const StepFigures& figures);
  /// Fields, when the step is due or `force` is set; never twice for a step, never with field_interval 0.
  [[nodiscard]] Result<void> write_fields(const FlowState& state, const FieldAverages& averages, bool force);
  /// averages.csv, anew; nothing before the averages start.
  [[nodiscard]] Result<void> write_averages(const FieldAverages& averages) const;

  /// How far the files are written: noted for a checkpoint, and gone back to.
  [[nodiscard]] Result<void> save_positions(const std::filesystem::path& file);
  [[nodiscard]] Result<void> restore_positions(const std::filesystem::path& file);

 private:
  [[nodiscard]] io::ResultFiles files();
  Results(const Settings& settings, const FluidMesh& mesh) : settings_(&settings), mesh_(&mesh) {}

  const Settings* settings_;
  const FluidMesh* mesh_;
  std::filesystem::path directory_;
  io::PvdCollection collection_;
  io::CsvWriter flow_;
  io::CsvWriter forces_;
  std::optional<io::CsvWriter> probe_series_;
  Probes probes_;
  std::optional<std::uint64_t> last_field_step_;
};

} // namespace drogue::fluid
