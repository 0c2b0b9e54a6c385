// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fluid_solver/coupled_flow.hpp"
#include "participant/cpp/participant.hpp"

namespace drogue::fluid {

/// The coupler's view of the flow; on rank 0. Hands every call to all ranks as an Order.
class FluidParticipant final : public participant::Solver {
 public:
  /// `pids`: process ids of all ranks.
  FluidParticipant(const Case& input, CoupledFlow& flow, std::vector<std::int64_t> pids)
      : input_(input), flow_(flow), pids_(std::move(pids)) {}

  [[nodiscard]] participant::Description describe() override;
  [[nodiscard]] Result<void> configure(const participant::RunInfo& run) override;
  [[nodiscard]] Result<participant::InterfaceMesh> initialize() override;
  [[nodiscard]] Result<void> begin_step(const participant::StepInfo& step) override;
  [[nodiscard]] Result<participant::IterationReport> iterate(const participant::Fields& inputs,
                                                             participant::Fields& outputs) override;
  [[nodiscard]] Result<void> commit(bool write_output) override;
  [[nodiscard]] Result<void> rollback() override;
  [[nodiscard]] Result<participant::ReplacedMesh> replace_mesh(const participant::NewMesh& mesh,
                                                               bool restoring) override;
  [[nodiscard]] Result<void> checkpoint(const std::filesystem::path& directory) override;
  [[nodiscard]] Result<void> restore(const std::filesystem::path& directory) override;

 private:
  [[nodiscard]] Result<void> order(Order::Kind kind, std::vector<double> numbers = {}, std::string text = {});

  const Case& input_;
  CoupledFlow& flow_;
  std::vector<std::int64_t> pids_;
};

/// Serves the coupler: rank 0 talks, the others follow its orders until it stops. @note Collective
[[nodiscard]] Result<void> serve_flow(Case& input, const std::string& endpoint);

} // namespace drogue::fluid
