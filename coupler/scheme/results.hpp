// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <filesystem>

#include "common/base/result.hpp"
#include "common/io/csv.hpp"

namespace drogue::coupler {

using Vector3 = std::array<double, 3>;

/// One coupling iteration: a row of coupling.csv.
struct IterationRecord {
  double step = 0, attempt = 0, iteration = 0, time = 0;
  double residual_relative = 0; ///< ||r|| / max(increment, floor)
  double residual_absolute =
      0;                ///< ||r||, L2 over the square root of the area [length]; STRUCTURE_FIRST: [stress]
  double increment = 0; ///< ||d~ - d_n||, of the same dimension; STRUCTURE_FIRST: of the load
  double velocity_residual = 0; ///< ||v~ - v|| dt / max(||d~ - d_n||, floor)
  double sweep_defect = 0;      ///< ||(v_start + v)/2 dt - (d - d_n)|| / max(||d~ - d_n||, floor)
  Vector3 force_fluid{};        ///< integral of the load over the fluid surface [force]
  Vector3 force_structure{};    ///< sum of the nodal forces [force]
  double force_defect = 0;      ///< |difference| / max(|force_fluid|, tiny)
  /// Moments about the origin of the load at the displaced positions of either side [force times length].
  Vector3 moment_fluid{}, moment_structure{};
  /// Power of the load on the wall velocity of either side: times the step, the work of the step [power].
  double power_fluid = 0, power_structure = 0;
  /// L2 defect of the projected displacement and velocity, relative: projection::projection_defect.
  double displacement_defect = 0, velocity_defect = 0;
  /// Secants the accelerator used for the next iterate, and those its filter left out.
  double columns = 0, dropped_columns = 0;
  double smallest_volume_ratio = 0;
  /// The solvers' own iterations in this solve, and their residual after them relative to the step's first.
  double fluid_inner_iterations = 0, fluid_inner_residual = 0;
  double structure_inner_iterations = 0, structure_inner_residual = 0;
  double load_change = 0; ///< of the nodal forces, against those before (SERIAL: last iteration; else: given)
  double inner_converged = 1; ///< 1: the solvers' own iterations allow the step to end here
};

/// One committed step: a row of drag.csv.
struct StepRecord {
  double time = 0;
  Vector3 force{}; ///< fluid's force on the interface at t_{n+1}
  double drag_coefficient = 0;
  double load_factor = 1, withheld_first_load = 0;
  Vector3 mean_displacement{}; ///< area-weighted, since Initialize
  Vector3 vector_area{};       ///< int n dA over the structure's current surface: projected areas
  double iterations = 0;
  double converged = 1;
};

/// One change of the fluid's mesh: a row of remesh.csv. The defects are those of Replaced in wire.proto.
struct RemeshRecord {
  double step = 0, time = 0;
  double nodes_before = 0, nodes_after = 0;
  double mass_defect = 0, momentum_defect = 0, energy_defect = 0;
};

/// coupling.csv, drag.csv and remesh.csv, a row at a time; what is written stays.
class Results {
 public:
  [[nodiscard]] static Result<Results> create(const std::filesystem::path& run_directory,
                                              io::Existing existing = io::Existing::replace);
  /// Errors of all: as io::CsvWriter::row.
  [[nodiscard]] Result<void> iteration(const IterationRecord& r);
  [[nodiscard]] Result<void> step(const StepRecord& r);
  [[nodiscard]] Result<void> new_mesh(const RemeshRecord& r);
  /// How far the files are written: noted for a checkpoint, and gone back to.
  [[nodiscard]] Result<void> save_positions(const std::filesystem::path& file);
  [[nodiscard]] Result<void> restore_positions(const std::filesystem::path& file);
  /// Length of coupling.csv, and back to that.
  [[nodiscard]] std::uint64_t iterations_size() const { return coupling_.size(); }
  [[nodiscard]] Result<void> cut_iterations(std::uint64_t size) { return coupling_.cut(size); }

 private:
  io::CsvWriter coupling_, drag_, remesh_;
};

} // namespace drogue::coupler
