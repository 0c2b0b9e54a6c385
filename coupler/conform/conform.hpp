// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "coupler/conform/inputs.hpp"

namespace drogue::coupler {

/// `coupler conform [OPTIONS] -- PROGRAM ARGUMENTS`.
struct ConformCommand {
  std::vector<std::string> command; ///< program and arguments; --connect ENDPOINT is added
  std::string role;                 ///< empty: from the fields it names in Hello
  std::filesystem::path json;       ///< empty: none
  std::filesystem::path folder;     ///< of logs and results, kept; empty: a temporary one
  conform::Sizes sizes;
  double deadline = 60;          ///< seconds for each answer
  std::vector<std::string> only; ///< promises that are checked; empty: all
};

/// Plays a scripted coupler against a participant and checks every promise of docs/protocol.md: starts it
/// again and again, leads it into each state, and disturbs it there. Prints the report. Errors:
/// ErrorKind::peer when a promise is broken, ErrorKind::config when the program cannot be started.
[[nodiscard]] Result<void> check_conformance(const ConformCommand& command);

} // namespace drogue::coupler
