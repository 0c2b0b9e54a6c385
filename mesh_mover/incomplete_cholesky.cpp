// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/incomplete_cholesky.hpp"

#include <algorithm>

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

IncompleteCholesky::IncompleteCholesky(const SymmetricBlocks<double>& A, const RowParts& parts)
    : A_(A), parts_(parts), y_(3 * A.rows()), z_(3 * A.rows()) {
  L_.row_start.assign(1, 0);
  for (std::size_t i = 0; i < A.rows(); ++i) {
    const bool own = parts.own().has(i);
    const auto first = own ? static_cast<std::int32_t>(parts.begin(parts.part_of(i))) : 0;
    for (std::size_t k = A.begin(i); own && k <= A.diagonal(i); ++k) {
      if (A.column[k] < first) continue;
      L_.column.push_back(A.column[k]);
      source_.push_back(static_cast<std::int32_t>(k));
    }
    L_.row_start.push_back(static_cast<std::int32_t>(L_.column.size()));
  }
  L_.values.resize(9 * L_.column.size());
}

double IncompleteCholesky::factor() {
  double shift = 0;
  while (!try_factor(shift)) shift = shift == 0 ? 1e-3 : 4 * shift; // diagonally dominant in the end
  return shift;
}

bool IncompleteCholesky::try_factor(double shift) {
  std::vector<char> done(static_cast<std::size_t>(parts_.count()), 1);
  parts_.run([&](int part) {
    for (std::size_t i = parts_.begin(part); i < parts_.end(part); ++i)
      if (!factor_row(i, static_cast<float>(1 + shift))) {
        done[static_cast<std::size_t>(part)] = 0;
        return;
      }
  });
  return std::find(done.begin(), done.end(), 0) == done.end();
}

/// Row i of A = L D L^T on the pattern:
///   S_ij = A_ij - sum_{k < j} S_ik L_jk^T  with S_ik = L_ik D_k,   D_i = A_ii - sum_k S_ik L_ik^T.
bool IncompleteCholesky::factor_row(std::size_t i, float scale) noexcept {
  const std::size_t begin = L_.begin(i);
  const std::size_t diagonal = L_.diagonal(i);
  for (std::size_t p = begin; p < diagonal; ++p) {
    const auto j = static_cast<std::size_t>(L_.column[p]);
    Block S = A_.block(static_cast<std::size_t>(source_[p])).cast<float>();
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
  Block D = scale * A_.block(static_cast<std::size_t>(source_[diagonal])).cast<float>();
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

void IncompleteCholesky::apply(std::span<const double> r, std::span<double> z) {
  parts_.run([&](int part) { apply_part(part, r, z); });
}

void IncompleteCholesky::apply_part(int part, std::span<const double> r, std::span<double> z) noexcept {
  for (std::size_t i = parts_.begin(part); i < parts_.end(part); ++i) {
    Vector y = Eigen::Map<const Eigen::Vector3d>(&r[3 * i]).cast<float>();
    const std::size_t diagonal = L_.diagonal(i);
    for (std::size_t p = L_.begin(i); p < diagonal; ++p)
      y.noalias() -= L_.block(p) * Eigen::Map<const Vector>(&y_[3 * static_cast<std::size_t>(L_.column[p])]);
    Eigen::Map<Vector> y_i(&y_[3 * i]);
    Eigen::Map<Vector> z_i(&z_[3 * i]);
    y_i = y;
    z_i.noalias() = L_.block(diagonal) * y;
  }
  for (std::size_t i = parts_.end(part); i-- > parts_.begin(part);) {
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
