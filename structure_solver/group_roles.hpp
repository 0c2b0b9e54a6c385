// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/config/config.hpp"
#include "structure_solver/settings.hpp"

namespace drogue::structure {

/// Reports groups that are named twice where they can play one part only: as elements of two kinds or
/// materials, or as elements and in ignore_group; and probes of the same name.
void check_group_roles(const Settings& settings, config::Report& report);

} // namespace drogue::structure
