// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <google/protobuf/message.h>

#include "common/config/config.hpp"

namespace drogue::config {

/// Checks every rule (proto/drogue/v1/rules.proto) of `message` and of the messages in it, by reflection.
void check_rules(const google::protobuf::Message& message, const Source& source, Report& report);

} // namespace drogue::config
