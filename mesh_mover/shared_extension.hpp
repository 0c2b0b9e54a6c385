// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh_mover/extension.hpp"

namespace drogue::mesh_mover {

/// An extension whose work all ranks share. Lives on the first rank; what is asked of it goes to the others
/// as orders.
///
///     rank 0:  SharedExtension --prepare, extend*--> ~SharedExtension ... stop_other_ranks()
///     others:  serve_extensions() -----------------------------------------------> returns
class SharedExtension : public Extension {
 public:
  /// @note Collective, as all other functions: the others are in serve_extensions()
  explicit SharedExtension(ExtensionInput input);
  ~SharedExtension() override;

  [[nodiscard]] Result<void> prepare(std::span<const double> points) override;
  [[nodiscard]] Result<SolveOutcome> extend(std::span<double> u, std::span<const double> increment) override;

 private:
  std::uint64_t number_; // there may be several extensions at the same time
  std::unique_ptr<Extension> own_;
};

/// On the ranks but the first: does their share until the first calls stop_other_ranks(). They wait asleep.
/// @note Collective
void serve_extensions();
/// On the first rank. @note Collective
void stop_other_ranks();

} // namespace drogue::mesh_mover
