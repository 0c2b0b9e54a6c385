// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.hpp"

namespace drogue::coupler {

/// `coupler replay RECORD -- PROGRAM ARGUMENTS`.
struct ReplayCommand {
  std::filesystem::path record;     ///< RUN/record/NAME.record
  std::vector<std::string> command; ///< program and arguments; --connect ENDPOINT is added
  std::filesystem::path folder;     ///< of logs and results
  double deadline = 600;            ///< seconds for each answer
};

/// Plays the coupler's side of a recorded run to one participant, and compares its answers with the recorded
/// ones to the bit: a solver can be debugged alone, on what it met in a coupled run. Folders for results and
/// checkpoints lie in `folder`; a checkpoint of an earlier part, from which the recorded run was resumed, is
/// read where it was. Prints a line for each answer that differs. Errors: ErrorKind::peer when one differs,
/// or none came; ErrorKind::config when there is no record or program.
[[nodiscard]] Result<void> replay(const ReplayCommand& command);

} // namespace drogue::coupler
