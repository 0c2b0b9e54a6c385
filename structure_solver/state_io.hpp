// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "common/base/result.hpp"
#include "structure_solver/integrator.hpp"

namespace drogue::structure {

/// State files of kind "structure": arrays "displacement", "velocity", "acceleration" and, after a coupled
/// step, "interface_force", each {nodes, 3}; "energy" {5}, the ledger from its start energy on (absent before
/// the first step), and "halvings" {1}. Reading gives back every bit.
[[nodiscard]] Result<void> save_state(const std::filesystem::path& file, const Model& model,
                                      const State& state);

/// Errors (ErrorKind::config): not such a file, another kind of state, another mesh.
[[nodiscard]] Result<State> read_state(const std::filesystem::path& file, const Model& model);

} // namespace drogue::structure
