// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "participant/cpp/participant.hpp"

namespace drogue::participant {

/// A solver whose time step may be one of several parts of the coupling's:
///   begin_step --iterate--> end_part, begin_step --iterate--> ... --iterate--> commit
/// and from anywhere in there, after a rollback of the part under way, undo_parts.
class PartedSolver : public Solver {
 public:
  /// Makes the last iterate the state at the end of a part. Writes nothing and counts nothing.
  /// @pre after an iterate  @post as after commit, but undo_parts can take it back
  [[nodiscard]] virtual Result<void> end_part() = 0;
  /// The exact state before the first of the parts since the last commit. @pre no part is under way
  [[nodiscard]] virtual Result<void> undo_parts() = 0;
};

/// How an input goes from one coupling step to the next.
enum class Interpolation {
  linear,   ///< from its value at the last step's end to that of the iterate
  quadratic ///< through the value at the end of the step before as well, once there is one; see Subcycling in
            ///< subcycling.proto for when
};

/// Takes each step of the coupling in `parts` equal steps of the solver. In every coupling iteration all
/// parts are done anew. The inputs of a part are interpolated in time; an input X that comes with an input
/// X_start goes in a line from this to that. In the first step of a run an input counts as constant. Outputs
/// are those of the last part, or the means over the parts where the contract says so.
///
/// The solver must iterate to its own tolerance in each call.
class Subcycled final : public Solver {
 public:
  /// @param inner outlives this  @param parts at least 1
  Subcycled(PartedSolver& inner, int parts, Interpolation interpolation)
      : inner_(inner), parts_(parts), interpolation_(interpolation) {}

  [[nodiscard]] Description describe() override;
  [[nodiscard]] Result<void> configure(const RunInfo& run) override { return inner_.configure(run); }
  [[nodiscard]] Result<InterfaceMesh> initialize() override { return inner_.initialize(); }
  [[nodiscard]] Result<void> begin_step(const StepInfo& step) override;
  [[nodiscard]] Result<IterationReport> iterate(const Fields& inputs, Fields& outputs) override;
  [[nodiscard]] Result<void> commit(bool write_output) override;
  [[nodiscard]] Result<void> rollback() override;
  [[nodiscard]] std::optional<NewMesh> new_mesh() override { return inner_.new_mesh(); }
  [[nodiscard]] Result<ReplacedMesh> replace_mesh(const NewMesh& mesh, bool restoring) override;
  [[nodiscard]] Result<void> checkpoint(const std::filesystem::path& directory) override;
  [[nodiscard]] Result<void> restore(const std::filesystem::path& directory) override;

 private:
  /// The inputs of the part from `begin` to `end`, both as shares of the step.
  [[nodiscard]] Fields inputs_of_part(const Fields& inputs, double begin, double end) const;
  [[nodiscard]] FloatArray at(const Fields& inputs, const std::string& name, double share) const;

  PartedSolver& inner_;
  int parts_;
  Interpolation interpolation_;
  std::vector<std::string> means_; ///< outputs that are means over the step
  StepInfo step_;
  bool in_part_ = false;
  Fields given_;              ///< of the last iterate
  Fields last_, before_;      ///< at the ends of the last step and of the one before; empty: none
  double last_time_step_ = 0; ///< between the two
};

} // namespace drogue::participant
