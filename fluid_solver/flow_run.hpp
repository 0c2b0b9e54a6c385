// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>

#include "common/base/result.hpp"
#include "common/base/role.hpp"
#include "fluid_solver/averages.hpp"
#include "fluid_solver/field_files.hpp"
#include "fluid_solver/flow_solver.hpp"
#include "fluid_solver/results.hpp"
#include "fluid_solver/settings.hpp"

/// What the stand-alone run and the participant share: a loaded case, its solver and its results.
namespace drogue::fluid {

struct Case {
  Settings settings;
  FluidMesh mesh;
};

/// Loads a config and its mesh and checks both completely. Errors hold every finding with file:line:column. A
/// participant needs one DSD_SST phase and an interface; the coupler moves its mesh and keeps its states.
[[nodiscard]] Result<std::unique_ptr<Case>> load_case(const std::filesystem::path& file, Role role);

/// A solver and its pieces of the fields on every rank, tables and states on rank 0.
class FlowRun {
 public:
  explicit FlowRun(const Case& input) : input_(input), solver_(input.settings, input.mesh) {}

  /// Reads the initial state, if the settings name one; makes the initial flow divergence-free, if they say
  /// so.
  [[nodiscard]] Result<void> start();
  /// @note Collective
  [[nodiscard]] Result<void> open_results(const std::filesystem::path& directory,
                                          io::Existing existing = io::Existing::replace);
  [[nodiscard]] FlowSolver& solver() { return solver_; }
  [[nodiscard]] const FlowSolver& solver() const { return solver_; }
  /// After the last newton() of a step: judgement, forces and figures, commit, files. Errors
  /// (ErrorKind::numerical), with nothing committed or written: not converged, and the residual above
  /// `failure_tolerance` of the first. @note Collective
  [[nodiscard]] Result<StepFigures>
  finish_step(bool write_fields, double failure_tolerance = std::numeric_limits<double>::infinity());
  /// The last committed state's fields, unless they are written. @note Collective
  [[nodiscard]] Result<void> write_last_fields();
  /// Takes over a state with its averages. Errors: as FlowSolver::import_state.
  [[nodiscard]] Result<void> import_state(const io::State& file);
  /// @note Collective
  [[nodiscard]] Result<void> write_state(const std::filesystem::path& file);
  /// How far the files are written. @note Collective
  [[nodiscard]] Result<void> save_positions(const std::filesystem::path& file);
  [[nodiscard]] Result<void> restore_positions(const std::filesystem::path& file);

 private:
  const Case& input_;
  FlowSolver solver_;
  void average(const StepFigures& figures);

  std::optional<Results> results_; ///< on rank 0
  std::optional<FieldFiles> fields_;
  FieldAverages averages_;
};

} // namespace drogue::fluid
