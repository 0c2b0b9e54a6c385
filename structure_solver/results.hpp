// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "common/base/result.hpp"
#include "common/io/csv.hpp"
#include "common/io/positions.hpp"
#include "common/io/vtu.hpp"
#include "structure_solver/fields.hpp"
#include "structure_solver/integrator.hpp"
#include "structure_solver/line_forces.hpp"
#include "structure_solver/probes.hpp"

namespace drogue::structure {

/// Writes the results of a run into one folder:
///   structure.csv     a row every series_interval steps: time, step, Newton iterations, energies and their
///                     balance (docs/theory.md), unbalance, stresses, tensions, momentum sum of m v,
///                     weight sum of m g, sum of all other loads and of the interface's, reactions, forces of
///                     line groups
///   probes.csv        displacement, velocity and acceleration of each probe
///   structure_N.vtu, structure.pvd   every field_interval steps, on the current positions: displacement,
///   velocity,
///                     acceleration, principal second Piola-Kirchhoff stresses (nodes and cells), cable
///                     tension, wrinkle state (0 slack, 1 wrinkled, 2 taut)
/// A run that continues from step N writes structure_from_N.csv and so on, beside what the earlier run left.
class Results {
 public:
  Results(const Settings& settings, const Model& model, std::filesystem::path directory);

  /// Starts the files of a run whose first step is given; without, the first step that is written does.
  [[nodiscard]] Result<void> open(std::uint64_t first_step, io::Existing existing = io::Existing::replace);

  /// A committed step, for the output.
  struct Step {
    const State& state;
    const Balance& balance;
    int newton_iterations = 0;
    /// False leaves out the fields whatever their interval says.
    bool may_write_fields = true;
  };
  /// Writes what the intervals ask for at this step.
  [[nodiscard]] Result<void> step(const Step& step);
  /// Writes the fields of `state` unless that was done already or field_interval is 0.
  [[nodiscard]] Result<void> fields(const State& state);
  /// How far the files are written: noted for a checkpoint, and gone back to by another process that
  /// continues the run whose first step is given.
  [[nodiscard]] Result<void> save_positions(const std::filesystem::path& file);
  [[nodiscard]] Result<void> continue_from(const std::filesystem::path& file, std::uint64_t first_step);

 private:
  [[nodiscard]] io::ResultFiles files();
  [[nodiscard]] Result<void> row(const Step& step);
  [[nodiscard]] std::vector<std::string> series_columns() const;

  const OutputSettings settings_;
  const Model& model_;
  std::filesystem::path directory_;
  std::vector<ProbePoint> probes_;
  std::vector<LineForce> line_forces_;
  bool open_ = false;
  io::CsvWriter series_;
  std::optional<io::CsvWriter> probe_series_;
  io::PvdCollection collection_;
  std::optional<std::uint64_t> last_fields_;
};

} // namespace drogue::structure
