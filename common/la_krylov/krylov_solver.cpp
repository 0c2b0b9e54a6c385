// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/la_krylov/krylov_solver.hpp"

#include <petscksp.h>

#include "common/la_krylov/petsc_call.hpp"

namespace drogue::la {

struct KrylovSolver::State {
  Apply matrix;
  Apply preconditioner;
  std::size_t size = 0;
  Mat A = nullptr;
  KSP ksp = nullptr;
  Vec b = nullptr;
  Vec x = nullptr;

  ~State() {
    KSPDestroy(&ksp);
    MatDestroy(&A);
    VecDestroy(&b);
    VecDestroy(&x);
  }
};

namespace {

PetscErrorCode apply(const KrylovSolver::Apply& f, Vec in, Vec out) {
  const PetscScalar* r = nullptr;
  PetscScalar* z = nullptr;
  PetscInt n = 0;
  PetscCall(VecGetLocalSize(in, &n));
  PetscCall(VecGetArrayRead(in, &r));
  PetscCall(VecGetArrayWrite(out, &z));
  f({r, static_cast<std::size_t>(n)}, {z, static_cast<std::size_t>(n)});
  PetscCall(VecRestoreArrayWrite(out, &z));
  PetscCall(VecRestoreArrayRead(in, &r));
  return 0;
}

PetscErrorCode apply_matrix(Mat A, Vec in, Vec out) {
  KrylovSolver::Apply* f = nullptr;
  PetscCall(MatShellGetContext(A, &f));
  return apply(*f, in, out);
}

PetscErrorCode apply_preconditioner(PC pc, Vec in, Vec out) {
  KrylovSolver::Apply* f = nullptr;
  PetscCall(PCShellGetContext(pc, &f));
  return apply(*f, in, out);
}

} // namespace

KrylovSolver::KrylovSolver(std::unique_ptr<State> state) : state_(std::move(state)) {}
KrylovSolver::KrylovSolver(KrylovSolver&&) noexcept = default;
KrylovSolver& KrylovSolver::operator=(KrylovSolver&&) noexcept = default;
KrylovSolver::~KrylovSolver() = default;

Result<KrylovSolver> KrylovSolver::create(std::int32_t local_size, Apply matrix, Apply preconditioner,
                                          const KrylovOptions& options) {
  auto s = std::make_unique<State>();
  s->matrix = std::move(matrix);
  s->preconditioner = std::move(preconditioner);
  s->size = static_cast<std::size_t>(local_size);
  const PetscInt n = local_size;
  DROGUE_PETSC(MatCreateShell(PETSC_COMM_WORLD, n, n, PETSC_DETERMINE, PETSC_DETERMINE, &s->matrix, &s->A));
  DROGUE_PETSC(MatShellSetOperation(s->A, MATOP_MULT, reinterpret_cast<void (*)()>(apply_matrix)));
  DROGUE_PETSC(VecCreateMPIWithArray(PETSC_COMM_WORLD, 1, n, PETSC_DETERMINE, nullptr, &s->b));
  DROGUE_PETSC(VecCreateMPIWithArray(PETSC_COMM_WORLD, 1, n, PETSC_DETERMINE, nullptr, &s->x));
  DROGUE_PETSC(KSPCreate(PETSC_COMM_WORLD, &s->ksp));
  DROGUE_PETSC(KSPSetOperators(s->ksp, s->A, s->A));
  DROGUE_PETSC(KSPSetType(s->ksp, KSPGMRES));
  DROGUE_PETSC(KSPGMRESSetRestart(s->ksp, options.restart));
  DROGUE_PETSC(KSPSetPCSide(s->ksp, PC_LEFT));
  DROGUE_PETSC(KSPSetNormType(s->ksp, KSP_NORM_PRECONDITIONED));
  DROGUE_PETSC(KSPSetTolerances(s->ksp, options.tolerance, 1e-50, PETSC_DEFAULT, options.max_iterations));
  PC pc = nullptr;
  DROGUE_PETSC(KSPGetPC(s->ksp, &pc));
  DROGUE_PETSC(PCSetType(pc, PCSHELL));
  DROGUE_PETSC(PCShellSetContext(pc, &s->preconditioner));
  DROGUE_PETSC(PCShellSetApply(pc, apply_preconditioner));
  return KrylovSolver(std::move(s));
}

Result<Outcome> KrylovSolver::solve(std::span<const double> b, std::span<double> x) {
  State& s = *state_;
  DROGUE_PETSC(VecPlaceArray(s.b, b.data()));
  DROGUE_PETSC(VecPlaceArray(s.x, x.data()));
  DROGUE_PETSC(KSPSolve(s.ksp, s.b, s.x));
  DROGUE_PETSC(VecResetArray(s.b));
  DROGUE_PETSC(VecResetArray(s.x));
  Outcome outcome;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  DROGUE_PETSC(KSPGetConvergedReason(s.ksp, &reason));
  DROGUE_PETSC(KSPGetIterationNumber(s.ksp, &iterations));
  DROGUE_PETSC(KSPGetResidualNorm(s.ksp, &outcome.residual));
  outcome.converged = reason > 0;
  outcome.iterations = iterations;
  return outcome;
}

} // namespace drogue::la
