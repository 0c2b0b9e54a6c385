// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "common/config/config.hpp"
#include "coupler/settings.hpp"

namespace drogue::coupler {

/// Loads a case and checks it offline: its own file, that every program exists, and, with each program's own
/// `check` command, the config of each participant that has one. Every error of all of them lands in
/// `report`; the settings are meaningful only when it stays empty.
[[nodiscard]] CaseSettings check_case(const std::filesystem::path& file, config::Report& report);

} // namespace drogue::coupler
