// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "common/base/result.hpp"

namespace drogue::la {

/// How an iteration ended.
struct Outcome {
  bool converged = false;
  int iterations = 0;
  double residual = 0;
};

struct KrylovOptions {
  /// Stop at this fraction of the first preconditioned residual norm.
  double tolerance = 1e-2;
  int max_iterations = 300;
  int restart = 60;
};

/// PETSc's GMRES over the own rows of every rank, operator and preconditioner given as functions. Left
/// preconditioning: the stopping test measures M^-1 r, an estimate of the error itself, so that no component
/// of the unknowns (the pressure) can hide behind the scale of another's equations.
class KrylovSolver {
 public:
  /// out = f(in), both own rows. Every rank calls it the same number of times.
  using Apply = std::function<void(std::span<const double> in, std::span<double> out)>;

  [[nodiscard]] static Result<KrylovSolver> create(std::int32_t local_size, Apply matrix,
                                                   Apply preconditioner, const KrylovOptions& options);
  KrylovSolver(KrylovSolver&&) noexcept;
  KrylovSolver& operator=(KrylovSolver&&) noexcept;
  ~KrylovSolver();

  /// Solves from x = 0. `converged` is true only when the tolerance was met. @note Collective
  [[nodiscard]] Result<Outcome> solve(std::span<const double> b, std::span<double> x);

 private:
  struct State;
  explicit KrylovSolver(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

} // namespace drogue::la
