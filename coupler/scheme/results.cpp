// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/scheme/results.hpp"

#include "common/io/positions.hpp"

namespace drogue::coupler {

Result<Results> Results::create(const std::filesystem::path& run_directory, io::Existing existing) {
  Results results;
  auto coupling = io::CsvWriter::create(run_directory / "coupling.csv",
                                        {"step",
                                         "attempt",
                                         "iteration",
                                         "time",
                                         "residual_relative",
                                         "residual_absolute",
                                         "increment",
                                         "velocity_residual",
                                         "sweep_defect",
                                         "force_fluid_x",
                                         "force_fluid_y",
                                         "force_fluid_z",
                                         "force_structure_x",
                                         "force_structure_y",
                                         "force_structure_z",
                                         "force_defect",
                                         "columns",
                                         "dropped_columns",
                                         "smallest_volume_ratio",
                                         "fluid_inner_iterations",
                                         "fluid_inner_residual",
                                         "structure_inner_iterations",
                                         "structure_inner_residual",
                                         "inner_converged",
                                         "moment_fluid_x",
                                         "moment_fluid_y",
                                         "moment_fluid_z",
                                         "moment_structure_x",
                                         "moment_structure_y",
                                         "moment_structure_z",
                                         "power_fluid",
                                         "power_structure",
                                         "displacement_defect",
                                         "velocity_defect",
                                         "load_change"},
                                        existing);
  if (!coupling) return coupling.error();
  results.coupling_ = std::move(*coupling);
  auto drag = io::CsvWriter::create(run_directory / "drag.csv",
                                    {"time", "force_x", "force_y", "force_z", "cd", "load_factor",
                                     "mean_displacement_x", "mean_displacement_y", "mean_displacement_z",
                                     "vector_area_x", "vector_area_y", "vector_area_z", "iterations",
                                     "converged", "withheld_first_load"},
                                    existing);
  if (!drag) return drag.error();
  results.drag_ = std::move(*drag);
  auto remesh = io::CsvWriter::create(
      run_directory / "remesh.csv",
      {"step", "time", "nodes_before", "nodes_after", "mass_defect", "momentum_defect", "energy_defect"},
      existing);
  if (!remesh) return remesh.error();
  results.remesh_ = std::move(*remesh);
  return results;
}

Result<void> Results::save_positions(const std::filesystem::path& file) {
  return io::save_positions(file, {{&coupling_, &drag_, &remesh_}, {}});
}

Result<void> Results::restore_positions(const std::filesystem::path& file) {
  return io::restore_positions(file, {{&coupling_, &drag_, &remesh_}, {}});
}

Result<void> Results::iteration(const IterationRecord& r) {
  return coupling_.row({r.step,
                        r.attempt,
                        r.iteration,
                        r.time,
                        r.residual_relative,
                        r.residual_absolute,
                        r.increment,
                        r.velocity_residual,
                        r.sweep_defect,
                        r.force_fluid[0],
                        r.force_fluid[1],
                        r.force_fluid[2],
                        r.force_structure[0],
                        r.force_structure[1],
                        r.force_structure[2],
                        r.force_defect,
                        r.columns,
                        r.dropped_columns,
                        r.smallest_volume_ratio,
                        r.fluid_inner_iterations,
                        r.fluid_inner_residual,
                        r.structure_inner_iterations,
                        r.structure_inner_residual,
                        r.inner_converged,
                        r.moment_fluid[0],
                        r.moment_fluid[1],
                        r.moment_fluid[2],
                        r.moment_structure[0],
                        r.moment_structure[1],
                        r.moment_structure[2],
                        r.power_fluid,
                        r.power_structure,
                        r.displacement_defect,
                        r.velocity_defect,
                        r.load_change});
}

Result<void> Results::step(const StepRecord& r) {
  return drag_.row({r.time, r.force[0], r.force[1], r.force[2], r.drag_coefficient, r.load_factor,
                    r.mean_displacement[0], r.mean_displacement[1], r.mean_displacement[2], r.vector_area[0],
                    r.vector_area[1], r.vector_area[2], r.iterations, r.converged, r.withheld_first_load});
}

Result<void> Results::new_mesh(const RemeshRecord& r) {
  return remesh_.row(
      {r.step, r.time, r.nodes_before, r.nodes_after, r.mass_defect, r.momentum_defect, r.energy_defect});
}

} // namespace drogue::coupler
