// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/config/config.hpp"
#include "structure_solver/model.hpp"

namespace drogue::structure {

/// Adds drag and the control of natural lengths to a model that has its elements. Groups that do not fit are
/// reported.
void add_drag_and_lengths(const Settings& settings, config::Report& report, Model& model);

} // namespace drogue::structure
