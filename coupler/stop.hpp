// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// SIGINT and SIGTERM. While a run can be stopped in order, the first asks for that: the coupling iteration
/// under way is finished, the step taken back, a checkpoint written. One that comes more than a second later,
/// and every one at other times, ends the waits for participants at once (launcher::Hub::interrupt).
namespace drogue::coupler::stop {

void catch_signals();
/// From now on a stop in order is possible, or not any more.
void set_orderly(bool orderly) noexcept;
/// A stop in order was asked for.
[[nodiscard]] bool requested() noexcept;

} // namespace drogue::coupler::stop
