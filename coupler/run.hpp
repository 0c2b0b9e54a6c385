// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "common/base/result.hpp"
#include "coupler/settings.hpp"

namespace drogue::coupler {

/// A whole coupled run: run directory, launch, steps, summary. SIGINT and SIGTERM end it with a checkpoint
/// and ErrorKind::interrupted. Whatever the outcome, no process is left behind and every result written
/// stays.
/// @param record keep every message in RUN/record
[[nodiscard]] Result<void> run_case(const CaseSettings& settings, bool record = false);

/// How to go on with an earlier run.
struct Resume {
  std::filesystem::path run_directory;
  std::optional<std::uint64_t> step; ///< from the checkpoint of this step; absent: from the newest
  bool accept_changes = false;       ///< of configs and meshes since the checkpoint
  bool record = false;               ///< keep every message in RUN/record
};

/// Continues a run from a checkpoint: the rest is, to the bit, what it would have been. One that was cut
/// short or altered is reported, and the one before it used. Errors: as run_case; ErrorKind::config when
/// there is no checkpoint, or something the results depend on has changed.
[[nodiscard]] Result<void> resume_run(const Resume& resume);

} // namespace drogue::coupler
