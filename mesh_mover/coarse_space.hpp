// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "common/base/result.hpp"
#include "common/la_direct/direct_solver.hpp"
#include "mesh_mover/shared_rows.hpp"

namespace drogue::mesh_mover {

/// Bit i of an entry: component i of the node's displacement is given. Shape {nodes}.
using Mask = std::vector<std::uint8_t>;

/// The coarse level of the two-level preconditioner: the nodes are gathered into aggregates of neighbours,
/// each of which moves like a rigid body, in the free components. With Z these translations and infinitesimal
/// rotations (six columns an aggregate), E = Z^T A Z is factored directly.
class CoarseSpace {
 public:
  /// Gathers the nodes; depends on the pattern and the mask alone. `A`, `given` and `rows` must outlive this
  /// object.
  CoarseSpace(const SymmetricBlocks<double>& A, const Mask& given, const SharedRows& rows);

  /// Factors E for the values of A. `positions` {3 rows} of the nodes.
  /// Errors (ErrorKind::internal): E is not positive definite. @note Collective
  [[nodiscard]] Result<void> factor(std::span<const double> positions);
  /// z += Z E^-1 Z^T r, for the own rows; `r` and `z` {nodes, 3}. @note Collective
  [[nodiscard]] Result<void> add(std::span<const double> r, std::span<double> z);

  [[nodiscard]] std::int32_t aggregate_count() const { return count_; }

 private:
  void gather(const SymmetricBlocks<double>& A);
  void find_pattern(const SymmetricBlocks<double>& A);
  void find_arms(std::span<const double> positions);
  void sum_blocks();
  [[nodiscard]] Eigen::Matrix3d rotations(std::size_t row) const noexcept;

  const SymmetricBlocks<double>& A_;
  const Mask& given_;
  const SharedRows& rows_;
  std::int32_t count_ = 0;
  std::vector<std::int32_t> aggregate_; // of each node; -1 when all its components are given
  std::vector<double> arms_;            // of each node from its aggregate's centre, by the aggregate's radius
  SymmetricBlocks<double, 6> coarse_;   // E
  std::vector<std::int32_t> places_;    // block of E to which each block of A adds; -1: none
  std::vector<double> rhs_;
  la::CholeskySolver solver_;
};

} // namespace drogue::mesh_mover
