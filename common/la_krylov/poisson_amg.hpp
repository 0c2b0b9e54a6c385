// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/base/result.hpp"
#include "common/la_krylov/node_graph.hpp"

namespace drogue::la {

/// One V-cycle of hypre's BoomerAMG, through PETSc, for a scalar elliptic matrix: a fixed linear operator.
class PoissonAmg {
 public:
  /// The own rows of the matrix: `pattern` in local numbers, one value an entry. @note Collective
  [[nodiscard]] static Result<PoissonAmg> create(const LocalPattern& pattern, const RowRange& own,
                                                 std::span<const double> values);
  PoissonAmg(PoissonAmg&&) noexcept;
  PoissonAmg& operator=(PoissonAmg&&) noexcept;
  ~PoissonAmg();

  /// z ~ K^-1 r on the own rows. False when the library failed. @note Collective
  [[nodiscard]] bool apply(std::span<const double> r, std::span<double> z);

 private:
  struct State;
  explicit PoissonAmg(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

} // namespace drogue::la
