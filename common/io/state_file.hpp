// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.hpp"

namespace drogue::io {

/// A named array of float64, row-major.
struct StateArray {
  std::string name;
  std::vector<std::uint64_t> shape;
  std::vector<double> values;
};

/// The state of one solver: what a checkpoint, and the hand-over between the stages of a pipeline, hold.
/// Format: proto/drogue/v1/state.proto.
struct State {
  std::string kind;
  std::string mesh_hash;
  double time = 0;
  std::uint64_t step = 0;
  std::vector<StateArray> arrays;

  void add(std::string name, std::vector<std::uint64_t> shape, std::vector<double> values) {
    arrays.push_back({std::move(name), std::move(shape), std::move(values)});
  }
  /// nullptr when there is none of that name.
  [[nodiscard]] const StateArray* find(const std::string& name) const;
};

/// Written to a temporary file and renamed.
[[nodiscard]] Result<void> write_state(const std::filesystem::path& file, const State& state);
/// Errors (ErrorKind::config): not a state file, truncated, wrong checksum: says which array.
[[nodiscard]] Result<State> read_state(const std::filesystem::path& file);

} // namespace drogue::io
