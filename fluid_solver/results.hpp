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

/// The tables of a run: flow.csv, forces.csv, probes.csv, averages.csv. Used on rank 0 only.
class Results {
 public:
  [[nodiscard]] static Result<Results> create(const Settings& settings, const FluidMesh& mesh,
                                              const std::filesystem::path& directory,
                                              io::Existing existing = io::Existing::replace);
  /// The probes' values, and a row of the other series when the step is due.
  [[nodiscard]] Result<void> write_series(const FlowState& state, const StepFigures& figures);
  /// averages.csv, anew; nothing before the averages start.
  [[nodiscard]] Result<void> write_averages(const FieldAverages& averages) const;

  /// Where the probes are, the nodes being at x {n, 3}; and puts them at places of another mesh.
  /// Errors (ErrorKind::config): a place outside the fluid.
  [[nodiscard]] std::vector<std::array<double, 3>> probe_positions(std::span<const double> x) const {
    return probes_.positions(x);
  }
  [[nodiscard]] Result<void> place_probes(const FluidMesh& mesh,
                                          const std::vector<std::array<double, 3>>& positions);

  /// How far the files and the collection of fields are written: noted for a checkpoint, and gone back to.
  [[nodiscard]] Result<void> save_positions(const std::filesystem::path& file, io::PvdCollection& fields);
  [[nodiscard]] Result<void> restore_positions(const std::filesystem::path& file, io::PvdCollection& fields);

 private:
  [[nodiscard]] io::ResultFiles files(io::PvdCollection& fields);
  explicit Results(const Settings& settings) : settings_(&settings) {}

  const Settings* settings_;
  std::filesystem::path directory_;
  io::CsvWriter flow_;
  io::CsvWriter forces_;
  std::optional<io::CsvWriter> probe_series_;
  Probes probes_;
};

} // namespace drogue::fluid
