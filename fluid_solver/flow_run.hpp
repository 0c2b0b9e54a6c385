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

/// What carrying a flow over to another mesh changed: the net volume flux through the boundary, relative to
/// the gross flux; the momentum, relative to the integral of its magnitude; the kinetic energy, relative to
/// itself.
struct TransferDefects {
  double mass = 0;
  double momentum = 0;
  double energy = 0;
};

/// A solver and its pieces of the fields on every rank, tables and states on rank 0.
class FlowRun {
 public:
  /// `input` must outlive the run; replace_mesh changes its mesh.
  explicit FlowRun(Case& input) : input_(input), solver_(std::in_place, input.settings, input.mesh) {}

  /// Reads the initial state, if the settings name one, from another mesh where they name that, too; makes
  /// the initial flow divergence-free, if they say so.
  [[nodiscard]] Result<void> start();
  /// @note Collective
  [[nodiscard]] Result<void> open_results(const std::filesystem::path& directory,
                                          io::Existing existing = io::Existing::replace);
  [[nodiscard]] FlowSolver& solver() { return *solver_; }
  [[nodiscard]] const FlowSolver& solver() const { return *solver_; }
  /// After the last newton() of a step: judgement, forces and figures, commit, files. Errors
  /// (ErrorKind::numerical), with nothing committed or written: not converged, and the residual above
  /// `failure_tolerance` of the first. @note Collective
  [[nodiscard]] Result<StepFigures>
  finish_step(bool write_fields, double failure_tolerance = std::numeric_limits<double>::infinity());
  /// The last committed state's fields, unless they are written. @note Collective
  [[nodiscard]] Result<void> write_last_fields();
  /// Takes over a state with its averages. Errors: as FlowSolver::import_state. @note Collective
  [[nodiscard]] Result<void> import_state(const io::State& file);
  /// @note Collective
  [[nodiscard]] Result<void> write_state(const std::filesystem::path& file);
  /// Goes over to the mesh of a file between two steps: same domain, same boundary triangulation. Velocity
  /// and pressure are projected (MeshTransfer) and settle (FlowSolver::settle); averages are interpolated;
  /// probes stay where they are. `restoring`: import_state follows, nothing is carried over. Errors: the file
  /// holds another mesh than that of the hash, or one that does not fit (ErrorKind::config); as MeshTransfer
  /// and settle. @note Collective
  [[nodiscard]] Result<TransferDefects> replace_mesh(const std::filesystem::path& file,
                                                     const std::string& hash, bool restoring);
  /// How far the files are written. @note Collective
  [[nodiscard]] Result<void> save_positions(const std::filesystem::path& file);
  [[nodiscard]] Result<void> restore_positions(const std::filesystem::path& file);

 private:
  [[nodiscard]] Result<void> start_from_other_mesh(const io::State& file);
  void average(const StepFigures& figures);
  void take(FluidMesh next);

  Case& input_;
  std::optional<FlowSolver> solver_; ///< always one, made anew when the mesh is replaced

  std::optional<Results> results_; ///< on rank 0
  std::optional<FieldFiles> fields_;
  FieldAverages averages_;
  std::vector<std::array<double, 3>> probe_positions_; ///< when the mesh was replaced; empty: it was not
};

} // namespace drogue::fluid
