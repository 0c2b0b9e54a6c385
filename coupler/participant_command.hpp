// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "coupler/settings.hpp"

/// How the coupler calls a participant's program, for its check as for the run.
namespace drogue::coupler {

/// What the program finds in its environment beside the coupler's own: DROGUE_PARTICIPANT, the case's
/// entries, and defaults that either may override: one BLAS thread a process, MPI that starts as any user and
/// waits passively.
[[nodiscard]] std::vector<std::string> participant_environment(const ParticipantSettings& p);

/// PROGRAM run CONFIG or PROGRAM ARGUMENTS, with --connect ENDPOINT; under mpiexec when it has several ranks.
/// One that is started by hand is named as the case names it. Errors (ErrorKind::config): there is no such
/// program.
[[nodiscard]] Result<std::vector<std::string>> run_command(const ParticipantSettings& p,
                                                           const std::string& endpoint);

/// What somebody types into a shell to run `arguments` with `environment`.
[[nodiscard]] std::string shell_line(const std::vector<std::string>& environment,
                                     const std::vector<std::string>& arguments);

} // namespace drogue::coupler
