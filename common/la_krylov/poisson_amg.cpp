// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/la_krylov/poisson_amg.hpp"

#include <petscksp.h>

#include "common/la_krylov/petsc_call.hpp"

namespace drogue::la {

struct PoissonAmg::State {
  Mat K = nullptr;
  PC pc = nullptr;
  Vec r = nullptr;
  Vec z = nullptr;

  ~State() {
    PCDestroy(&pc);
    MatDestroy(&K);
    VecDestroy(&r);
    VecDestroy(&z);
  }
};

namespace {

/// Settings for three-dimensional Laplacians: cheap coarse levels, one cycle.
Result<void> set_options() {
  constexpr const char* options[][2] = {
      {"-pressure_pc_hypre_boomeramg_max_iter", "1"},
      {"-pressure_pc_hypre_boomeramg_tol", "0"},
      {"-pressure_pc_hypre_boomeramg_strong_threshold", "0.5"},
      {"-pressure_pc_hypre_boomeramg_coarsen_type", "HMIS"},
      {"-pressure_pc_hypre_boomeramg_interp_type", "ext+i"},
      {"-pressure_pc_hypre_boomeramg_P_max", "4"},
      {"-pressure_pc_hypre_boomeramg_agg_nl", "1"},
  };
  for (const auto& [name, value] : options) DROGUE_PETSC(PetscOptionsSetValue(nullptr, name, value));
  return {};
}

} // namespace

PoissonAmg::PoissonAmg(std::unique_ptr<State> state) : state_(std::move(state)) {}
PoissonAmg::PoissonAmg(PoissonAmg&&) noexcept = default;
PoissonAmg& PoissonAmg::operator=(PoissonAmg&&) noexcept = default;
PoissonAmg::~PoissonAmg() = default;

Result<PoissonAmg> PoissonAmg::create(const LocalPattern& pattern, const RowRange& own,
                                      std::span<const double> values) {
  auto s = std::make_unique<State>();
  std::vector<PetscInt> columns(pattern.column.size());
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const std::int32_t c = pattern.column[k];
    columns[k] =
        c < pattern.rows ? own.first + c : pattern.ghosts[static_cast<std::size_t>(c - pattern.rows)];
  }
  DROGUE_PETSC(MatCreateMPIAIJWithArrays(PETSC_COMM_WORLD, pattern.rows, pattern.rows, PETSC_DETERMINE,
                                         PETSC_DETERMINE, pattern.row_start.data(), columns.data(),
                                         values.data(), &s->K));
  DROGUE_TRY(set_options());
  DROGUE_PETSC(PCCreate(PETSC_COMM_WORLD, &s->pc));
  DROGUE_PETSC(PCSetOptionsPrefix(s->pc, "pressure_"));
  DROGUE_PETSC(PCSetType(s->pc, PCHYPRE));
  DROGUE_PETSC(PCHYPRESetType(s->pc, "boomeramg"));
  DROGUE_PETSC(PCSetFromOptions(s->pc));
  DROGUE_PETSC(PCSetOperators(s->pc, s->K, s->K));
  DROGUE_PETSC(PCSetUp(s->pc));
  DROGUE_PETSC(VecCreateMPIWithArray(PETSC_COMM_WORLD, 1, pattern.rows, PETSC_DETERMINE, nullptr, &s->r));
  DROGUE_PETSC(VecCreateMPIWithArray(PETSC_COMM_WORLD, 1, pattern.rows, PETSC_DETERMINE, nullptr, &s->z));
  return PoissonAmg(std::move(s));
}

bool PoissonAmg::apply(std::span<const double> r, std::span<double> z) {
  State& s = *state_;
  bool ok = VecPlaceArray(s.r, r.data()) == 0 && VecPlaceArray(s.z, z.data()) == 0;
  ok = ok && PCApply(s.pc, s.r, s.z) == 0;
  VecResetArray(s.r);
  VecResetArray(s.z);
  return ok;
}

} // namespace drogue::la
