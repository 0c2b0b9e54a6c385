// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>

#include "common/base/result.hpp"
#include "common/base/role.hpp"
#include "structure_solver/integrator.hpp"
#include "structure_solver/model.hpp"
#include "structure_solver/settings.hpp"

namespace drogue::structure {

/// A config with its mesh and its start: all that a run needs.
struct Case {
  Settings settings;
  std::unique_ptr<const Model> model;
  State start;

  [[nodiscard]] Integrator::Options integrator_options() const;
};

/// Reads config, mesh and initial state. Errors (ErrorKind::config): everything wrong with them, at once. A
/// participant needs an interface and dynamics, and writes no final state. With initial_at_rest the state
/// keeps its displacement, and time starts at 0.
[[nodiscard]] Result<Case> load_case(const std::filesystem::path& file, Role role = Role::alone);

/// `check FILE`: load_case without keeping anything.
[[nodiscard]] Result<void> check_case(const std::filesystem::path& file, Role role = Role::alone);

} // namespace drogue::structure
