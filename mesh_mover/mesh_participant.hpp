// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "mesh_mover/remesher.hpp"
#include "mesh_mover/results.hpp"
#include "participant/cpp/participant.hpp"

namespace drogue::mesh_mover {

/// mesh_mover as a participant of a coupled run.
///
/// Input:  "displacement"      {n, 3}  of the interface nodes since Initialize, at t_{n+1} [length]
///         "translation"       {1, 3}  of the translated boundaries since Initialize, at t_{n+1} [length]
/// Output: "mesh_displacement" {N, 3}  of all nodes since Initialize, at t_{n+1} [length]
///         "quality"           {1, 3}  smallest volume ratio, worst mean ratio, mean of the mean ratios
class MeshParticipant : public participant::Solver {
 public:
  /// @param input loaded for Role::participant
  /// @param pids of all ranks; empty: this process alone
  /// @param remesh_program see Remesher
  explicit MeshParticipant(Case input, std::vector<std::int64_t> pids = {},
                           std::filesystem::path remesh_program = {});

  [[nodiscard]] participant::Description describe() override;
  [[nodiscard]] Result<void> configure(const participant::RunInfo& run) override;
  [[nodiscard]] Result<participant::InterfaceMesh> initialize() override;
  [[nodiscard]] Result<void> begin_step(const participant::StepInfo& step) override;
  [[nodiscard]] Result<participant::IterationReport> iterate(const participant::Fields& inputs,
                                                             participant::Fields& outputs) override;
  [[nodiscard]] Result<void> commit(bool write_output) override;
  [[nodiscard]] Result<void> rollback() override;
  [[nodiscard]] std::optional<participant::NewMesh> new_mesh() override;
  [[nodiscard]] Result<participant::ReplacedMesh> replace_mesh(const participant::NewMesh& mesh,
                                                               bool restoring) override;
  [[nodiscard]] Result<void> checkpoint(const std::filesystem::path& directory) override;
  [[nodiscard]] Result<void> restore(const std::filesystem::path& directory) override;

 private:
  [[nodiscard]] participant::InterfaceMesh interface_mesh() const;

  Settings settings_;
  std::vector<std::int64_t> pids_;
  mesh::Mesh initial_mesh_; // until initialize
  std::unique_ptr<MeshMover> mover_;
  std::string mesh_hash_;
  Results results_;
  Remesher remesher_;
  std::optional<Replacement> replacement_; ///< of the last commit
  participant::StepInfo step_;
  SolveReport last_;
  double time_n_ = 0;
  std::uint64_t steps_done_ = 0;
  bool resume_ = false;
};

} // namespace drogue::mesh_mover
