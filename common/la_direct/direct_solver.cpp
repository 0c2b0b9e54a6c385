// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/la_direct/direct_solver.hpp"

#include <algorithm>
#include <cassert>
#include <csignal>
#include <cstring>
#include <vector>

#include <cholmod.h>
#include <umfpack.h>

#include "common/la_direct/column_kernels.hpp"

extern "C" {
void openblas_set_num_threads(int);
int omp_get_max_active_levels();
void omp_set_max_active_levels(int);
}

namespace drogue::la {

void use_one_blas_thread() {
  openblas_set_num_threads(1);
}

namespace {

/// Puts the program's action on SIGTERM back as it was: METIS, which orders for CHOLMOD, returns it as one
/// that serves once.
class KeptSignals {
 public:
  KeptSignals() { sigaction(SIGTERM, nullptr, &terminate_); }
  ~KeptSignals() { sigaction(SIGTERM, &terminate_, nullptr); }
  KeptSignals(const KeptSignals&) = delete;
  KeptSignals& operator=(const KeptSignals&) = delete;

 private:
  struct sigaction terminate_ = {};
};

/// While it lives, OpenMP regions run on the thread that meets them. CHOLMOD copies even its smallest fronts
/// in regions of four threads, whatever the environment says; their start and their spinning took half of the
/// factorisation of a structure.
class WithoutOpenMp {
 public:
  WithoutOpenMp() : levels_(omp_get_max_active_levels()) { omp_set_max_active_levels(0); }
  ~WithoutOpenMp() { omp_set_max_active_levels(levels_); }
  WithoutOpenMp(const WithoutOpenMp&) = delete;
  WithoutOpenMp& operator=(const WithoutOpenMp&) = delete;

 private:
  int levels_;
};

} // namespace

struct CholeskySolver::State {
  cholmod_common common{};
  cholmod_factor* factor = nullptr;
  cholmod_dense *solution = nullptr, *work1 = nullptr, *work2 = nullptr; // kept: solves allocate once
  int n = 0;
  // Of Use::many_solutions, in the place of CHOLMOD's factor.
  GroupedFactor grouped_factor;
  std::vector<int> order;
  CacheLines<double> interleaved; // of solve_by_columns

  explicit State(Use use) {
    const bool solutions = use == Use::many_solutions;
    cholmod_start(&common);
    common.print = 0;
    common.nmethods = 1;
    common.method[0].ordering = solutions ? CHOLMOD_AMD : CHOLMOD_METIS;
    common.postorder = 1;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.final_ll = 1;
    if (solutions) { // made by supernodes, then turned into columns without their zeros
      common.final_asis = 0;
      common.final_super = 0;
      common.final_resymbol = 1;
    }
    common.quick_return_if_not_posdef = 1;
  }
  ~State() {
    clear();
    cholmod_finish(&common);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  void solve_by_columns(const double* b, double* x, int columns);
  void solve_rows(double* y, int lanes) const noexcept {
    (lanes == 4 ? column_kernels().solve_4 : column_kernels().solve_8)(grouped_factor, y);
  }
  void group_columns();
  void clear() {
    if (factor) cholmod_free_factor(&factor, &common);
    for (cholmod_dense** dense : {&solution, &work1, &work2}) cholmod_free_dense(dense, &common);
  }
};

namespace {

cholmod_sparse view(const SparseMatrix& A) {
  cholmod_sparse v{};
  v.nrow = static_cast<std::size_t>(A.rows());
  v.ncol = static_cast<std::size_t>(A.cols());
  v.nzmax = static_cast<std::size_t>(A.nonZeros());
  v.p = const_cast<int*>(A.outerIndexPtr());
  v.i = const_cast<int*>(A.innerIndexPtr());
  v.x = const_cast<double*>(A.valuePtr());
  v.stype = 1; // the upper triangle
  v.itype = CHOLMOD_INT;
  v.xtype = CHOLMOD_REAL;
  v.dtype = CHOLMOD_DOUBLE;
  v.sorted = 1;
  v.packed = 1;
  return v;
}

} // namespace

CholeskySolver::CholeskySolver(Use use) : state_(std::make_unique<State>(use)) {}
CholeskySolver::~CholeskySolver() = default;
CholeskySolver::CholeskySolver(CholeskySolver&&) noexcept = default;
CholeskySolver& CholeskySolver::operator=(CholeskySolver&&) noexcept = default;

void CholeskySolver::forget_pattern() {
  state_->clear();
}

Result<bool> CholeskySolver::factor(const SparseMatrix& A) {
  assert(A.isCompressed() && A.rows() == A.cols());
  State& s = *state_;
  cholmod_sparse a = view(A);
  if (!s.factor) {
    const KeptSignals kept;
    s.factor = cholmod_analyze(&a, &s.common);
    if (!s.factor) return internal_error("CHOLMOD cannot analyse the matrix (status {})", s.common.status);
    s.n = static_cast<int>(A.rows());
  }
  if (s.n != A.rows()) return internal_error("CHOLMOD: the matrix changed its size without forget_pattern()");
  const WithoutOpenMp alone;
  cholmod_factorize(&a, s.factor, &s.common);
  if (s.common.status == CHOLMOD_NOT_POSDEF) return false;
  if (s.common.status < 0)
    return internal_error("CHOLMOD cannot factor the matrix (status {})", s.common.status);
  if (s.factor->minor != s.factor->n) return false;
  if (!s.factor->is_super) s.group_columns();
  return true;
}

/// Copies L into groups of columns, and gives CHOLMOD's back.
void CholeskySolver::State::group_columns() {
  grouped_factor = grouped({n, static_cast<int*>(factor->p), static_cast<int*>(factor->nz),
                            static_cast<int*>(factor->i), static_cast<double*>(factor->x)});
  const int* permutation = static_cast<int*>(factor->Perm);
  order.assign(permutation, permutation + n);
  clear();
}

/// L L^T x = b for up to eight right-hand sides at once, side by side in memory, by the columns of L: half
/// the time of CHOLMOD's supernodes, whose dense kernels have too little to do with three columns.
void CholeskySolver::State::solve_by_columns(const double* b, double* x, int columns) {
  const auto size = static_cast<std::size_t>(n);
  const std::size_t lanes = columns > 4 ? 8 : 4;
  interleaved.assign(lanes * size, 0.0);
  double* y = interleaved.data();
  for (std::size_t k = 0; k < size; ++k)
    for (int c = 0; c < columns; ++c)
      y[lanes * k + static_cast<std::size_t>(c)] =
          b[static_cast<std::size_t>(c) * size + static_cast<std::size_t>(order[k])];
  solve_rows(y, static_cast<int>(lanes));
  for (std::size_t k = 0; k < size; ++k)
    for (int c = 0; c < columns; ++c)
      x[static_cast<std::size_t>(c) * size + static_cast<std::size_t>(order[k])] =
          y[lanes * k + static_cast<std::size_t>(c)];
}

Result<void> CholeskySolver::solve(std::span<const double> b, std::span<double> x, int columns) {
  State& s = *state_;
  assert((s.factor || !s.order.empty()) && b.size() == x.size() &&
         b.size() == static_cast<std::size_t>(s.n) * static_cast<std::size_t>(columns));
  if (!s.factor) {
    for (int c = 0; c < columns; c += 8) {
      const auto start = static_cast<std::size_t>(c) * static_cast<std::size_t>(s.n);
      s.solve_by_columns(b.data() + start, x.data() + start, std::min(8, columns - c));
    }
    return {};
  }
  cholmod_dense rhs{};
  rhs.nrow = static_cast<std::size_t>(s.n);
  rhs.ncol = static_cast<std::size_t>(columns);
  rhs.nzmax = b.size();
  rhs.d = rhs.nrow;
  rhs.x = const_cast<double*>(b.data());
  rhs.xtype = CHOLMOD_REAL;
  rhs.dtype = CHOLMOD_DOUBLE;
  if (!cholmod_solve2(CHOLMOD_A, s.factor, &rhs, nullptr, &s.solution, nullptr, &s.work1, &s.work2,
                      &s.common))
    return internal_error("CHOLMOD cannot solve (status {})", s.common.status);
  std::memcpy(x.data(), s.solution->x, x.size_bytes());
  return {};
}

std::span<const int> CholeskySolver::order() const {
  return state_->order;
}

void CholeskySolver::solve_rows(std::span<double> y, int lanes) noexcept {
  const State& s = *state_;
  assert(!s.order.empty() && (lanes == 4 || lanes == 8) &&
         y.size() == static_cast<std::size_t>(s.n) * static_cast<std::size_t>(lanes));
  s.solve_rows(y.data(), lanes);
}

struct LuSolver::State {
  void* symbolic = nullptr;
  void* numeric = nullptr;
  SparseMatrix matrix; // UMFPACK needs it again for the iterative refinement of every solve
  double control[UMFPACK_CONTROL];

  explicit State(Refinement refinement) {
    umfpack_di_defaults(control);
    control[UMFPACK_ORDERING] = UMFPACK_ORDERING_METIS;
    if (refinement == Refinement::none) control[UMFPACK_IRSTEP] = 0;
  }
  ~State() { clear(); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  void clear() {
    if (numeric) umfpack_di_free_numeric(&numeric);
    if (symbolic) umfpack_di_free_symbolic(&symbolic);
  }
};

LuSolver::LuSolver(Refinement refinement) : state_(std::make_unique<State>(refinement)) {}
LuSolver::~LuSolver() = default;
LuSolver::LuSolver(LuSolver&&) noexcept = default;
LuSolver& LuSolver::operator=(LuSolver&&) noexcept = default;

void LuSolver::forget_pattern() {
  state_->clear();
}

Result<bool> LuSolver::factor(const SparseMatrix& A) {
  assert(A.isCompressed() && A.rows() == A.cols());
  State& s = *state_;
  s.matrix = A;
  double info[UMFPACK_INFO];
  const int n = static_cast<int>(A.rows());
  const int* p = s.matrix.outerIndexPtr();
  const int* i = s.matrix.innerIndexPtr();
  const double* v = s.matrix.valuePtr();
  if (!s.symbolic) {
    const int status = umfpack_di_symbolic(n, n, p, i, v, &s.symbolic, s.control, info);
    if (status != UMFPACK_OK) return internal_error("UMFPACK cannot analyse the matrix (status {})", status);
  }
  if (s.numeric) umfpack_di_free_numeric(&s.numeric);
  const int status = umfpack_di_numeric(p, i, v, s.symbolic, &s.numeric, s.control, info);
  if (status == UMFPACK_WARNING_singular_matrix) return false;
  if (status != UMFPACK_OK) return internal_error("UMFPACK cannot factor the matrix (status {})", status);
  return true;
}

Result<void> LuSolver::solve(std::span<const double> b, std::span<double> x) {
  State& s = *state_;
  assert(s.numeric && b.size() == x.size());
  const std::vector<double> rhs(b.begin(), b.end()); // b and x may be the same memory
  double info[UMFPACK_INFO];
  const int status = umfpack_di_solve(UMFPACK_A, s.matrix.outerIndexPtr(), s.matrix.innerIndexPtr(),
                                      s.matrix.valuePtr(), x.data(), rhs.data(), s.numeric, s.control, info);
  if (status != UMFPACK_OK) return internal_error("UMFPACK cannot solve (status {})", status);
  return {};
}

} // namespace drogue::la
