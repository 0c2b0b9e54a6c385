// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "common/config/config.hpp"
#include "coupler/settings.hpp"

namespace drogue::coupler {

/// Checks a case offline: its own file, that every program exists, and, with each program's own `check`
/// command, the config of each of Drogue's solvers. Every error lands in `report`.
void check_case(const std::filesystem::path& file, config::Report& report);

/// The same for a case that is loaded already.
void check_participants(const CaseSettings& settings, config::Report& report);

} // namespace drogue::coupler
