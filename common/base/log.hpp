// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include <spdlog/spdlog.h>

namespace drogue {

/// Sends spdlog's default logger to standard error with the program's name in every line:
/// "12:34:56.789 structure_solver info  text".
void start_log(const std::string& program);

} // namespace drogue
