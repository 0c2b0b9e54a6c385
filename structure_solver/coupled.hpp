// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "participant/cpp/subcycled.hpp"
#include "structure_solver/case.hpp"
#include "structure_solver/results.hpp"

namespace drogue::structure {

/// The structure in a coupled run.
///
/// Inputs on the interface nodes: "force" {n, 3}, the fluid's nodal forces at t_{n+1}; "displacement" {n, 3},
/// the coupler's iterate, measured since Initialize. Newton starts from it on the interface nodes and from
/// the last iterate of the step (the predictor at first) elsewhere, so that the map from (force,
/// displacement) to the outputs has no hidden state on the interface. Outputs: "displacement" {n, 3} since
/// Initialize, "velocity" {n, 3}.
///
/// Pressures, gravity and the other loads of the config act as well.
class Coupled : public participant::PartedSolver {
 public:
  /// @param c loaded for Role::participant
  explicit Coupled(Case c);

  [[nodiscard]] participant::Description describe() override;
  [[nodiscard]] Result<void> configure(const participant::RunInfo& run) override;
  [[nodiscard]] Result<participant::InterfaceMesh> initialize() override;
  [[nodiscard]] Result<void> begin_step(const participant::StepInfo& step) override;
  [[nodiscard]] Result<participant::IterationReport> iterate(const participant::Fields& inputs,
                                                             participant::Fields& outputs) override;
  [[nodiscard]] Result<void> commit(bool write_output) override;
  [[nodiscard]] Result<void> rollback() override;
  [[nodiscard]] Result<void> checkpoint(const std::filesystem::path& directory) override;
  [[nodiscard]] Result<void> restore(const std::filesystem::path& directory) override;
  [[nodiscard]] Result<void> end_part() override;
  [[nodiscard]] Result<void> undo_parts() override;
  [[nodiscard]] int parts() const { return case_.settings.parts; }
  [[nodiscard]] participant::Interpolation interpolation() const {
    return case_.settings.quadratic_inputs ? participant::Interpolation::quadratic
                                           : participant::Interpolation::linear;
  }
  /// Writes the fields of the last committed step unless that was done; to be called when the run has ended.
  [[nodiscard]] Result<void> finish();

 private:
  void start_iterate(const participant::Fields& inputs);
  [[nodiscard]] participant::FloatArray on_interface(std::span<const double> values) const;

  Case case_;
  Integrator integrator_;
  std::optional<Results> results_;
  std::vector<std::int32_t> nodes_;    // of the interface, sorted
  std::vector<double> u_initial_;      // on the interface, at Initialize
  std::vector<double> force_, target_; // work space of iterate
  std::optional<State> before_parts_;  ///< while parts of a step are done
  int step_iterations_ = 0;            ///< with parts: of the last one
  bool resume_ = false;
  bool advanced_ = false; ///< a step was committed, or restored: there is something to write at the end
};

} // namespace drogue::structure
