// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/direct_solver.hpp"

#include <algorithm>

namespace drogue::mesh_mover {
namespace {

constexpr int none = -1;

} // namespace

DirectSolver::DirectSolver(const SymmetricBlocks<double>& A, const Mask& given) : A_(A), given_(given) {
  for (std::size_t i = 0; i < A.rows(); ++i)
    for (int c = 0; c < 3; ++c) unknown_.push_back(given[i] >> c & 1 ? none : count_++);
  values_.resize(static_cast<std::size_t>(count_));
}

Result<void> DirectSolver::update() {
  if (count_ == 0) return {};
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < A_.rows(); ++i)
    for (std::size_t k = A_.begin(i); k <= A_.diagonal(i); ++k) {
      const auto block = A_.block(k);
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) { // row i is the larger: its blocks fill columns of the upper triangle
          const int column = unknown_[3 * i + static_cast<std::size_t>(a)];
          const int row = unknown_[3 * static_cast<std::size_t>(A_.column[k]) + static_cast<std::size_t>(b)];
          if (row != none && row <= column) entries.emplace_back(row, column, block(a, b));
        }
    }
  upper_.resize(count_, count_);
  upper_.setFromTriplets(entries.begin(), entries.end());
  const auto factored = cholesky_.factor(upper_);
  if (!factored) return factored.error();
  if (!*factored) return internal_error("the matrix of the mesh motion is not positive definite");
  return {};
}

Result<void> DirectSolver::solve(std::span<const double> b, std::span<double> x) {
  for (std::size_t i = 0; i < unknown_.size(); ++i)
    if (unknown_[i] != none) values_[static_cast<std::size_t>(unknown_[i])] = b[i];
  if (count_ > 0) DROGUE_TRY(cholesky_.solve(values_, values_));
  for (std::size_t i = 0; i < unknown_.size(); ++i)
    x[i] = unknown_[i] == none ? b[i] : values_[static_cast<std::size_t>(unknown_[i])];
  return {};
}

} // namespace drogue::mesh_mover
