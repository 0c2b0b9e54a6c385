// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>

#include "common/base/result.hpp"
#include "coupler/checkpoint_store.hpp"
#include "coupler/origin.hpp"
#include "coupler/scheme/step_loop.hpp"

namespace drogue::coupler {

/// Writes the checkpoints of a running case, and takes one up again. A checkpoint holds the state of every
/// participant, the loop's, and how far the result files are written.
class Checkpoints {
 public:
  /// @param directory of the run
  Checkpoints(const CaseSettings& settings, Participants& participants, StepLoop& loop, Results& results,
              const std::filesystem::path& directory, std::vector<Input> inputs);

  /// After every step: writes one when the settings, or a request file, ask for it.
  [[nodiscard]] Result<void> after_step(std::uint64_t step, double time);
  /// Writes one, unless it is there. Errors: whatever goes wrong; the checkpoints before it stay.
  [[nodiscard]] Result<void> write(std::uint64_t step, double time);
  /// Everything as it was at the end of a step; checkpoints of later steps are removed.
  [[nodiscard]] Result<void> restore(std::uint64_t step);
  /// Everything as it was at the end of another run; what is counted over a run starts at zero.
  [[nodiscard]] Result<void> start_from(const Origin& origin);

 private:
  using Clock = std::chrono::steady_clock;
  [[nodiscard]] bool due(std::uint64_t step, double time);
  [[nodiscard]] Result<void> take_up(const std::filesystem::path& folder, std::uint64_t step,
                                     const std::optional<MeshFile>& mesh);
  [[nodiscard]] Result<void> write_own(const std::filesystem::path& folder, std::uint64_t step, double time);

  const CaseSettings& settings_;
  Participants& participants_;
  StepLoop& loop_;
  Results& results_;
  std::filesystem::path directory_;
  CheckpointStore store_;
  std::vector<Input> inputs_;
  std::optional<std::uint64_t> last_step_; ///< of the last checkpoint written or restored
  double last_time_ = 0;
  Clock::time_point last_at_ = Clock::now();
};

/// Asks the coupler that runs in `run_directory` for a checkpoint and waits until it is written. Errors:
/// nobody runs there (config), the run ended before (peer), none was written (internal), too late (peer).
[[nodiscard]] Result<std::uint64_t> request_checkpoint(const std::filesystem::path& run_directory,
                                                       std::chrono::duration<double> deadline);

} // namespace drogue::coupler
