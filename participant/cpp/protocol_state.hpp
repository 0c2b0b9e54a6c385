// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string_view>

#include "drogue/v1/wire.pb.h"

namespace drogue::participant {

/// States of a participant as both sides see it; the diagram stands in participant.hpp.
enum class ProtocolState { connected, greeted, configured, ready, in_step, iterated, failed, finished };

[[nodiscard]] std::string_view name(ProtocolState state);
/// Name of a request or response, e.g. "BeginStep"; "nothing" for an empty body.
[[nodiscard]] std::string_view name(v1::Envelope::BodyCase body);

/// The state after `body` was sent (Hello) or answered without error (requests); nothing when it is not
/// allowed in `from`. The one table both sides use.
[[nodiscard]] std::optional<ProtocolState> next_state(ProtocolState from, v1::Envelope::BodyCase body);

} // namespace drogue::participant
