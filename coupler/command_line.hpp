// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/base/result.hpp"

namespace drogue::coupler {

/// Parses the command line and does what it asks. Returns the exit status: 0 done, 1 internal, 2 bad config
/// or command line, 3 numerical failure, 4 a participant died or did not answer, 5 interrupted.
[[nodiscard]] int command_line(int argc, char** argv);

} // namespace drogue::coupler
