// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace drogue {

/// From now on SIGINT and SIGTERM are noted instead of ending the process; one that comes more than a second
/// after the first ends it at once (launchers and terminals may deliver the same one twice). A run looks at
/// interrupted() after each step (a participant after each request) and ends in order, with
/// ErrorKind::interrupted.
void catch_interrupts();

[[nodiscard]] bool interrupted() noexcept;

} // namespace drogue
