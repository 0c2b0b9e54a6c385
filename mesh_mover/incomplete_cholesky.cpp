// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/incomplete_cholesky.hpp"

#include <Eigen/LU>

namespace drogue::mesh_mover {
namespace {

using Block = SymmetricBlocks<float>::Block;
using Vector = Eigen::Vector3f;

bool is_positive_definite(const Block& D) noexcept {
  const float minor = D(0, 0) * D(1, 1) - D(1, 0) * D(1, 0);
  return D(0, 0) > 0 && minor > 0 && D.determinant() > 0;
}

} // namespace

double IncompleteCholesky::factor(const SymmetricBlocks<double>& A) {
  if (L_.column.size() != A.column.size()) {
    L_.row_start = A.row_start;
    L_.column = A.column;
    L_.values.resize(A.values.size());
    y_.resize(3 * A.rows());
    z_.resize(3 * A.rows());
  }
  double shift = 0;
  while (!try_factor(A, shift)) shift = shift == 0 ? 1e-3 : 4 * shift; // diagonally dominant in the end
  return shift;
}

bool IncompleteCholesky::try_factor(const SymmetricBlocks<double>& A, double shift) {
  for (std::size_t i = 0; i < A.rows(); ++i)
    if (!factor_row(A, i, static_cast<float>(1 + shift))) return false;
  return true;
}

/// Row i of A = L D L^T on the pattern:
///   S_ij = A_ij - sum_{k < j} S_ik L_jk^T  with S_ik = L_ik D_k,   D_i = A_ii - sum_k S_ik L_ik^T.
bool IncompleteCholesky::factor_row(const SymmetricBlocks<double>& A, std::size_t i, float scale) {
  const std::size_t begin = L_.begin(i);
  const std::size_t diagonal = L_.diagonal(i);
  for (std::size_t p = begin; p < diagonal; ++p) {
    const auto j = static_cast<std::size_t>(L_.column[p]);
    Block S = A.block(p).cast<float>();
    std::size_t a = begin;
    std::size_t b = L_.begin(j);
    const std::size_t end_b = L_.diagonal(j);
    while (a < p && b < end_b) {
      if (L_.column[a] == L_.column[b])
        S.noalias() -= L_.block(a++) * L_.block(b++).transpose();
      else if (L_.column[a] < L_.column[b])
        ++a;
      else
        ++b;
    }
    L_.block(p) = S;
  }
  Block D = scale * A.block(diagonal).cast<float>();
  for (std::size_t p = begin; p < diagonal; ++p) {
    const auto j = static_cast<std::size_t>(L_.column[p]);
    const Block S = L_.block(p);
    const Block L = S * L_.block(L_.diagonal(j));
    D.noalias() -= S * L.transpose();
    L_.block(p) = L;
  }
  if (!is_positive_definite(D)) return false;
  L_.block(diagonal) = D.inverse();
  return true;
}

void IncompleteCholesky::apply(std::span<const double> r, std::span<double> z) noexcept {
  for (std::size_t i = 0; i < L_.rows(); ++i) {
    Vector y = Eigen::Map<const Eigen::Vector3d>(&r[3 * i]).cast<float>();
    const std::size_t diagonal = L_.diagonal(i);
    for (std::size_t p = L_.begin(i); p < diagonal; ++p)
      y.noalias() -= L_.block(p) * Eigen::Map<const Vector>(&y_[3 * static_cast<std::size_t>(L_.column[p])]);
    Eigen::Map<Vector> y_i(&y_[3 * i]);
    Eigen::Map<Vector> z_i(&z_[3 * i]);
    y_i = y;
    z_i.noalias() = L_.block(diagonal) * y;
  }
  for (std::size_t i = L_.rows(); i-- > 0;) {
    const Vector z_i = Eigen::Map<const Vector>(&z_[3 * i]);
    const std::size_t begin = L_.begin(i);
    for (std::size_t p = L_.diagonal(i); p-- > begin;) // backwards, as memory is read
      Eigen::Map<Vector>(&z_[3 * static_cast<std::size_t>(L_.column[p])]).noalias() -=
          L_.block(p).transpose() * z_i;
    Eigen::Map<Eigen::Vector3d> target(&z[3 * i]);
    target = z_i.cast<double>();
  }
}

} // namespace drogue::mesh_mover
