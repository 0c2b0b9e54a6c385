// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/conjugate_gradient.hpp"

#include <cstdlib>

#include <petscksp.h>

namespace drogue::mesh_mover {
namespace {

static_assert(sizeof(PetscInt) == sizeof(std::int32_t), "PETSc must be built with 32-bit indices");

Error petsc_error(const char* call, PetscErrorCode code) {
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  return internal_error("PETSc: {} failed: {}", call, text ? text : "unknown error");
}

#define DROGUE_PETSC(call)                                                                                   \
  do {                                                                                                       \
    if (const PetscErrorCode petsc_code = (call)) return petsc_error(#call, petsc_code);                     \
  } while (false)

} // namespace

Result<std::unique_ptr<PetscSession>> PetscSession::start() {
  // A program started without mpiexec is a run of its own: Open MPI must not start a daemon for it.
  if (!std::getenv("OMPI_COMM_WORLD_SIZE")) setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
  DROGUE_PETSC(PetscOptionsSetValue(nullptr, "-no_signal_handler", "true"));
  DROGUE_PETSC(PetscInitializeNoArguments());
  std::unique_ptr<PetscSession> session(new PetscSession);
  DROGUE_PETSC(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));
  int ranks = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  if (ranks > 1) return config_error("mesh_mover works on one rank; it was started on {}", ranks);
  return session;
}

PetscSession::~PetscSession() {
  PetscFinalize();
}

struct ConjugateGradient::State {
  Mat A = nullptr;
  Vec b = nullptr;
  Vec x = nullptr;
  KSP ksp = nullptr;
  std::span<double> values; // memory of A
  bool fell_back = false;

  State() = default;
  ~State() {
    KSPDestroy(&ksp);
    VecDestroy(&x);
    VecDestroy(&b);
    MatDestroy(&A);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  Result<void> create(const BlockPattern& pattern);
  Result<void> precondition(PCType type);
  Result<SolveOutcome> solve(KSPConvergedReason& reason);
};

Result<void> ConjugateGradient::State::create(const BlockPattern& pattern) {
  const PetscInt n = pattern.rows();
  DROGUE_PETSC(MatCreate(PETSC_COMM_SELF, &A));
  DROGUE_PETSC(MatSetSizes(A, 3 * n, 3 * n, 3 * n, 3 * n));
  DROGUE_PETSC(MatSetType(A, MATSEQBAIJ));
  DROGUE_PETSC(MatSeqBAIJSetPreallocationCSR(A, 3, pattern.row_start.data(), pattern.column.data(), nullptr));
  PetscScalar* memory = nullptr;
  DROGUE_PETSC(MatSeqBAIJGetArray(A, &memory));
  values = {memory, 9 * pattern.column.size()};
  DROGUE_PETSC(MatSeqBAIJRestoreArray(A, &memory));
  DROGUE_PETSC(MatSetOption(A, MAT_SYMMETRIC, PETSC_TRUE));
  DROGUE_PETSC(VecCreateSeqWithArray(PETSC_COMM_SELF, 3, 3 * n, nullptr, &b));
  DROGUE_PETSC(VecCreateSeqWithArray(PETSC_COMM_SELF, 3, 3 * n, nullptr, &x));
  DROGUE_PETSC(KSPCreate(PETSC_COMM_SELF, &ksp));
  DROGUE_PETSC(KSPSetType(ksp, KSPCG));
  DROGUE_PETSC(KSPSetNormType(ksp, KSP_NORM_UNPRECONDITIONED));
  DROGUE_PETSC(KSPSetInitialGuessNonzero(ksp, PETSC_TRUE));
  DROGUE_PETSC(KSPSetOperators(ksp, A, A));
  return {};
}

Result<void> ConjugateGradient::State::precondition(PCType type) {
  PC pc = nullptr;
  DROGUE_PETSC(KSPGetPC(ksp, &pc));
  DROGUE_PETSC(PCSetType(pc, type));
  DROGUE_PETSC(KSPSetUp(ksp));
  return {};
}

Result<SolveOutcome> ConjugateGradient::State::solve(KSPConvergedReason& reason) {
  DROGUE_PETSC(KSPSolve(ksp, b, x));
  PetscInt iterations = 0;
  PetscReal residual = 0;
  DROGUE_PETSC(KSPGetConvergedReason(ksp, &reason));
  DROGUE_PETSC(KSPGetIterationNumber(ksp, &iterations));
  DROGUE_PETSC(KSPGetResidualNorm(ksp, &residual));
  return SolveOutcome{reason > 0, static_cast<int>(iterations), residual};
}

ConjugateGradient::ConjugateGradient() : state_(std::make_unique<State>()) {}
ConjugateGradient::~ConjugateGradient() = default;

Result<void> ConjugateGradient::create(const BlockPattern& pattern) {
  return state_->create(pattern);
}
std::span<double> ConjugateGradient::values() {
  return state_->values;
}

Result<void> ConjugateGradient::update() {
  State& s = *state_;
  // The values changed behind PETSc's back.
  DROGUE_PETSC(MatAssemblyBegin(s.A, MAT_FINAL_ASSEMBLY));
  DROGUE_PETSC(MatAssemblyEnd(s.A, MAT_FINAL_ASSEMBLY));
  s.fell_back = false;
  return s.precondition(PCILU);
}

bool ConjugateGradient::fell_back() const {
  return state_->fell_back;
}

Result<SolveOutcome> ConjugateGradient::solve(std::span<const double> b, std::span<double> x,
                                              double tolerance, int max_iterations) {
  State& s = *state_;
  const std::vector<double> start(x.begin(), x.end());
  DROGUE_PETSC(KSPSetTolerances(s.ksp, 1e-300, tolerance, 1e300, max_iterations));
  DROGUE_PETSC(VecPlaceArray(s.b, b.data()));
  DROGUE_PETSC(VecPlaceArray(s.x, x.data()));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  auto outcome = s.solve(reason);
  if (outcome && (reason == KSP_DIVERGED_INDEFINITE_PC || reason == KSP_DIVERGED_PC_FAILED)) {
    std::copy(start.begin(), start.end(), x.begin());
    s.fell_back = true;
    if (auto changed = s.precondition(PCPBJACOBI); !changed)
      outcome = changed.error();
    else
      outcome = s.solve(reason);
  }
  DROGUE_PETSC(VecResetArray(s.b));
  DROGUE_PETSC(VecResetArray(s.x));
  return outcome;
}

Result<void> ConjugateGradient::multiply(std::span<const double> x, std::span<double> y) {
  State& s = *state_;
  DROGUE_PETSC(VecPlaceArray(s.b, x.data()));
  DROGUE_PETSC(VecPlaceArray(s.x, y.data()));
  const PetscErrorCode code = MatMult(s.A, s.b, s.x);
  DROGUE_PETSC(VecResetArray(s.b));
  DROGUE_PETSC(VecResetArray(s.x));
  if (code) return petsc_error("MatMult", code);
  return {};
}

} // namespace drogue::mesh_mover
