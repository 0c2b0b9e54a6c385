// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "structure_solver/model.hpp"

namespace drogue::structure {

/// How workers share an assembly. Each worker owns some of the nodes, and so their equations: rows of the
/// residual, columns of the tangent. It evaluates every element that touches one of its nodes, in the
/// elements' order, and adds to its own equations alone. Nobody waits, and every sum is formed in the same
/// order whatever the number of workers: the result is the same to the last bit. Price: elements on the
/// border between two workers are evaluated by both.
///
/// Nodes are owned in slices across the longest side of the structure, of equal work.
struct WorkSplit {
  using Elements = std::vector<std::int32_t>;

  std::vector<std::int32_t> owner; ///< of each node
  /// Nodes of each worker, {workers, own nodes}, ascending.
  std::vector<std::vector<std::int32_t>> nodes;
  /// Elements of each worker, {workers, batches, elements}, ascending; and of the pressure batches.
  std::vector<std::vector<Elements>> elements;
  std::vector<std::vector<Elements>> pressure_elements;
};

[[nodiscard]] WorkSplit split_work(const Model& model, int workers);

} // namespace drogue::structure
