// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace drogue {

/// How a solver is used: on its own, or as a participant of a coupled run. Its config must hold more, and may
/// not hold some things, for the second.
enum class Role { alone, participant };

} // namespace drogue
