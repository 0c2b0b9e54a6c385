// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/coupled_case.hpp"

/// Coupled runs that the verification tests set up: our own programs, files written by the test.
namespace drogue::test {

/// What a run left behind, a value a step.
struct CoupledRun {
  Table steps;      ///< drag.csv
  Table iterations; ///< coupling.csv
  /// Coupling iterations a step, without the first `leave_out` steps.
  [[nodiscard]] double mean_iterations(std::size_t leave_out = 0) const;
  [[nodiscard]] double most_iterations() const;
};

/// Runs `folder`/case.textproto; false when it does not end well. What the coupler said is in output.txt.
[[nodiscard]] bool ends_well(const std::filesystem::path& folder, std::chrono::minutes longest);

/// Runs `folder`/case.textproto, whose run directory is "run". The test fails unless the run ends well.
[[nodiscard]] CoupledRun run_coupled(const std::filesystem::path& folder, std::chrono::minutes longest);

/// A column of a table.
[[nodiscard]] std::vector<double> column(const Table& table, const std::string& name);

} // namespace drogue::test
