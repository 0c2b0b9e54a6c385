// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "mesh_mover/row_parts.hpp"

namespace drogue::mesh_mover {

/// Incomplete factors L D L^T of a symmetric positive definite matrix on its own pattern, by 3 x 3 blocks, in
/// single precision: as a preconditioner it only steers the iteration, and half the memory is half the time.
/// Couplings between the parts of the rows are left out, so that each part has a thread of its own; so are
/// the rows of other ranks.
///
/// Where a pivot block is not positive definite, the factorisation starts again with all diagonal blocks
/// enlarged (Manteuffel's shift), so that the preconditioner is always symmetric positive definite.
class IncompleteCholesky {
 public:
  /// `A` and `parts` must outlive this object; A's values may change.
  IncompleteCholesky(const SymmetricBlocks<double>& A, const RowParts& parts);

  /// Returns the shift that was needed, usually 0. @pre A has positive definite diagonal blocks
  double factor();
  /// z = (L D L^T)^-1 r; `r` and `z` {3 rows}.
  void apply(std::span<const double> r, std::span<double> z);

 private:
  [[nodiscard]] bool try_factor(double shift);
  [[nodiscard]] bool factor_row(std::size_t i, float scale) noexcept;
  void apply_part(int part, std::span<const double> r, std::span<double> z) noexcept;

  const SymmetricBlocks<double>& A_;
  const RowParts& parts_;
  std::vector<std::int32_t> source_; // block of A of each block of L
  SymmetricBlocks<float> L_;         // strictly lower blocks L_ij; on the diagonal D_i^-1
  std::vector<float> y_;             // L y = r
  std::vector<float> z_;             // D^-1 y, then the solution
};

} // namespace drogue::mesh_mover
