// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/base/result.hpp"
#include "coupler/settings.hpp"

namespace drogue::coupler {

/// A whole coupled run: run directory, launch, steps, summary. SIGINT and SIGTERM end it with
/// ErrorKind::interrupted. Whatever the outcome, no process is left behind and every result written stays.
[[nodiscard]] Result<void> run_case(const CaseSettings& settings);

} // namespace drogue::coupler
