// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/linear_solver.hpp"

#include <utility>

namespace drogue::mesh_mover {
namespace {

/// Nodes up to which direct factors are quicker. In three dimensions a factorisation grows with the square of
/// the nodes.
constexpr std::size_t largest_direct_2d = 300'000;
constexpr std::size_t largest_direct_3d = 2'000;

} // namespace

bool is_direct(LinearSolverKind kind, std::size_t nodes, int dimension) {
  switch (kind) {
  case LinearSolverKind::direct:
    return true;
  case LinearSolverKind::iterative:
    return false;
  case LinearSolverKind::automatic:
    break;
  }
  return nodes <= (dimension == 2 ? largest_direct_2d : largest_direct_3d);
}

LinearSolver::LinearSolver(const SymmetricBlocks<double>& A, const Mask& given, int dimension,
                           LinearSolverKind kind, SharedRows rows) {
  if (mesh_mover::is_direct(kind, A.rows(), dimension))
    direct_ = std::make_unique<DirectSolver>(A, given);
  else
    iterative_ = std::make_unique<ConjugateGradient>(A, given, std::move(rows));
}

Result<void> LinearSolver::update(std::span<const double> positions) {
  return direct_ ? direct_->update() : iterative_->update(positions);
}

Result<SolveOutcome> LinearSolver::solve(std::span<const double> b, std::span<double> x, double tolerance,
                                         int max_iterations) {
  if (iterative_) return iterative_->solve(b, x, tolerance, max_iterations);
  DROGUE_TRY(direct_->solve(b, x));
  return SolveOutcome{true, 1, 0};
}

} // namespace drogue::mesh_mover
