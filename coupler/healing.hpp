// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "coupler/checkpoint_store.hpp"
#include "coupler/settings.hpp"

namespace drogue::coupler {

/// Where a run, or its next part, starts.
struct Start {
  std::uint64_t step = 0; ///< done before
  bool resumed = false;   ///< from the checkpoint of that step
};

/// Runs that outlive their participants. After a death or a silence everybody is ended and started again, and
/// the run goes on from its newest whole checkpoint, or from its start when there is none. As every solve is
/// deterministic, the steps done again, and so all results, are to the bit those of the undisturbed run.
class Healing {
 public:
  /// Notes what the run's inputs hold now: a run whose inputs have changed since is not continued.
  /// @param directory of the run
  Healing(const CaseSettings& settings, const std::filesystem::path& directory);

  /// Where to go on after `error`; nothing when the run ends with it: no participant was lost, a signal asked
  /// for the end, the restarts are used up, or an input has changed. Logs what it does, and why.
  [[nodiscard]] std::optional<Start> after(const Error& error);

 private:
  [[nodiscard]] Start newest_start() const;

  const CaseSettings& settings_;
  std::filesystem::path directory_;
  std::vector<Input> inputs_;
  int restarts_ = 0;
};

} // namespace drogue::coupler
