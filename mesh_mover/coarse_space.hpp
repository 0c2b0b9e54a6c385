// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "common/base/result.hpp"
#include "common/la_direct/direct_solver.hpp"
#include "mesh_mover/block_matrix.hpp"

namespace drogue::mesh_mover {

/// Bit i of an entry: component i of the node's displacement is given. Shape {nodes}.
using Mask = std::vector<std::uint8_t>;

/// The coarse level of the two-level preconditioner: the nodes are gathered into aggregates of neighbours,
/// each of which moves as a rigid translation of its free components. With Z these motions (three columns an
/// aggregate), E = Z^T A Z is factored directly.
class CoarseSpace {
 public:
  /// Gathers the nodes; depends on the pattern and the mask alone.
  CoarseSpace(const SymmetricBlocks<double>& A, const Mask& given);

  /// Factors E for the values of A. Errors (ErrorKind::internal): E is not positive definite.
  [[nodiscard]] Result<void> factor(const SymmetricBlocks<double>& A);
  /// z += Z E^-1 Z^T r; `r` and `z` {nodes, 3}.
  [[nodiscard]] Result<void> add(std::span<const double> r, std::span<double> z);

  [[nodiscard]] std::int32_t aggregate_count() const { return count_; }

 private:
  void gather(const SymmetricBlocks<double>& A);
  void find_pattern(const SymmetricBlocks<double>& A);

  const Mask& given_;
  std::int32_t count_ = 0;
  std::vector<std::int32_t> aggregate_; // of each node; -1 when all its components are given
  SymmetricBlocks<double> coarse_;      // E
  std::vector<std::int32_t> places_;    // block of E to which each block of A adds; -1: none
  std::vector<double> rhs_;
  la::CholeskySolver solver_;
};

} // namespace drogue::mesh_mover
