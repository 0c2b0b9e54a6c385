// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "fluid_solver/flow_run.hpp"

namespace drogue::fluid {

/// Nodal field of a mesh that has taken the place of another one: how far its nodes, where the file has them,
/// have come since the start of the run.
inline constexpr const char* start_displacement_name = "start_displacement";

/// Replaces the mesh of a stand-alone run when a step has left it beyond Settings::remesh.
class FlowRemesher {
 public:
  /// @param program that knows the command "remesh": the mesh is made in a process of its own, as it must be
  /// for runs
  ///        that repeat to the bit; empty: in this one
  FlowRemesher(const Case& input, std::filesystem::path program)
      : input_(input), program_(std::move(program)) {}

  /// True when it has replaced the mesh, by that of the file remesh_STEP.msh beside the results. A mesh that
  /// cannot be made is logged, and the old one stays for some steps at least.
  /// @param start {n, 3}: the nodes at the start of the run
  /// Errors: as FlowRun::replace_mesh. @note Collective
  [[nodiscard]] Result<bool> after_step(FlowRun& run, std::span<const double> start);

 private:
  [[nodiscard]] RemeshSettings limits() const;
  [[nodiscard]] mesh::NodeField worn(const std::vector<double>& x) const;
  [[nodiscard]] std::string trouble(const std::vector<double>& x) const;
  [[nodiscard]] Result<std::string> make(const FlowState& state, std::span<const double> start,
                                         const std::filesystem::path& file) const;

  const Case& input_;
  std::filesystem::path program_;
  RemeshSettings worn_{1, 180}; ///< beyond which a new mesh is replaced again
  std::uint64_t not_before_ = 0;
};

} // namespace drogue::fluid
