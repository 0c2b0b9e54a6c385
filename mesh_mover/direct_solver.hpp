// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh_mover/coarse_space.hpp"

namespace drogue::mesh_mover {

/// Sparse Cholesky factors of the free rows, for small meshes and for two dimensions, where they are quicker
/// than an iteration and do not mind how thin the elements are.
class DirectSolver {
 public:
  /// `A` and `given` must outlive this object; A's values may change between calls of update().
  DirectSolver(const SymmetricBlocks<double>& A, const Mask& given);

  /// The matrix has new values: factors it. Errors (ErrorKind::internal): it is not positive definite.
  [[nodiscard]] Result<void> update();
  /// Solves A x = b; `b` and `x` {3 rows}.
  [[nodiscard]] Result<void> solve(std::span<const double> b, std::span<double> x);

 private:
  const SymmetricBlocks<double>& A_;
  const Mask& given_;
  std::vector<int> unknown_; // of each row and component; -1: given
  int count_ = 0;
  std::vector<double> values_;
  la::SparseMatrix upper_;
  la::CholeskySolver cholesky_;
};

} // namespace drogue::mesh_mover
