// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/flow_system.hpp"

#include <algorithm>
#include <cmath>

#include "common/la_krylov/block_matrix.hpp"
#include "common/la_krylov/ghost_exchange.hpp"
#include "common/la_krylov/poisson_amg.hpp"
#include "common/la_krylov/session.hpp"
#include "fluid_solver/direct_solution.hpp"
#include "fluid_solver/element_loop.hpp"
#include "fluid_solver/open_boundary.hpp"
#include "fluid_solver/slip_projection.hpp"
#include "fluid_solver/time_matrix.hpp"

namespace drogue::fluid {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// Rows of the Laplacian int grad N_a . grad N_b. Nodes where the pressure is known (open boundaries, the
/// pinned node) get twice the diagonal: that holds their pressure softly and makes the matrix regular.
std::vector<double> laplacian(const FluidMesh& mesh, const VelocityConstraints& constraints,
                              const la::RowRange& own, const la::LocalPattern& pattern) {
  std::vector<double> values(pattern.column.size(), 0.0);
  for (std::int32_t e = 0; e < mesh.cell_count(); ++e) {
    const auto t = mesh.cell(e);
    const CellGeometry geometry = cell_geometry(mesh, mesh.points, e);
    for (std::size_t a = 0; a < t.size(); ++a) {
      if (!own.has(t[a])) continue;
      for (std::size_t b = 0; b < t.size(); ++b) {
        const double* ga = geometry.gradient[a];
        const double* gb = geometry.gradient[b];
        values[at(pattern.find(t[a] - own.first, pattern.local(own, t[b])))] +=
            geometry.volume * (ga[0] * gb[0] + ga[1] * gb[1] + ga[2] * gb[2]);
      }
    }
  }
  const auto hold = [&](std::int32_t node) {
    if (own.has(node)) values[at(pattern.diagonal[at(node - own.first)])] *= 2;
  };
  for (const std::int32_t node : constraints.open_nodes()) hold(node);
  if (constraints.pinned_node() >= 0) hold(constraints.pinned_node());
  return values;
}

/// Sizes up to which a factorisation is quicker than the Krylov method, or as quick and more robust.
bool choose_direct(const Settings& settings, const FluidMesh& mesh, std::size_t equations) {
  if (settings.linear_method != LinearMethod::automatic)
    return settings.linear_method == LinearMethod::direct;
  return la::rank_count() == 1 && equations <= (mesh.dimension == 2 ? 400000U : 2000U);
}

template <int n>
class BlockFlowSystem final : public FlowSystem {
 public:
  static constexpr int levels = n / 4;

  BlockFlowSystem(const Settings& settings, const FluidMesh& mesh, const VelocityConstraints& constraints)
      : settings_(settings),
        ranges_(la::partition_rows(mesh.graph, la::rank_count())),
        own_(ranges_[static_cast<std::size_t>(la::rank())]),
        pattern_(la::local_pattern(mesh.graph, own_)),
        exchange_(mesh.graph, ranges_, pattern_, la::rank(), n),
        elements_(mesh, own_, pattern_),
        open_(settings, mesh, own_, pattern_),
        slip_(constraints.slip_nodes(), own_, pattern_),
        matrix_(pattern_),
        residual_(rows() * n),
        rhs_(rows() * n),
        solution_(rows() * n),
        all_(at(mesh.node_count()) * n),
        local_(at(pattern_.columns()) * n),
        defect_(rows() * levels) {
    for (auto* v : {&level_in_, &level_out_}) v->resize(rows());
    for (std::int32_t i = own_.first; i < own_.last; ++i)
      for (int q = 0; q < levels; ++q) {
        for (int d = 0; d < 3; ++d)
          if (constraints.fixed()[3 * at(i) + at(d)]) fixed_.push_back({i - own_.first, 4 * q + d});
        if (i == constraints.pinned_node()) fixed_.push_back({i - own_.first, 4 * q + 3});
      }
  }

  /// @note Collective
  [[nodiscard]] Result<void> set_up(const FluidMesh& mesh, const VelocityConstraints& constraints) {
    if (settings_.linear_method == LinearMethod::direct && la::rank_count() > 1)
      return config_error("linear.method DIRECT works on one rank, here are {}: use KRYLOV",
                          la::rank_count());
    if (choose_direct(settings_, mesh, rows() * (at(mesh.dimension) + 1) * levels)) {
      std::vector<char> held(rows() * n, 0);
      for (const Fixed& f : fixed_) held[at(f.row) * n + at(f.component)] = 1;
      direct_.emplace(pattern_, held);
      return {};
    }
    auto amg = la::PoissonAmg::create(pattern_, own_, laplacian(mesh, constraints, own_, pattern_));
    if (!amg) return amg.error();
    amg_.emplace(std::move(*amg));
    ilu_.emplace(pattern_);
    pressure_rows_.emplace(pattern_);
    auto krylov = la::KrylovSolver::create(
        own_.size() * n, [this](auto in, auto out) { multiply(in, out); },
        [this](auto in, auto out) { precondition(in, out); }, settings_.linear);
    if (!krylov) return krylov.error();
    krylov_.emplace(std::move(*krylov));
    return {};
  }

  [[nodiscard]] int unknowns() const override { return n; }
  [[nodiscard]] std::span<const double> residual() const override { return residual_; }
  [[nodiscard]] la::RowRange own_rows() const override { return own_; }

  void begin_step(double dt, double reference_speed, bool convection) override {
    for (std::size_t q = 0; q < levels; ++q) {
      std::fill_n(scale_.begin() + static_cast<std::ptrdiff_t>(4 * q), 3, 1.0);
      scale_[4 * q + 3] = reference_speed;
    }
    parameters_ = {.dt = dt,
                   .nu = settings_.kinematic_viscosity(),
                   .smagorinsky = settings_.smagorinsky,
                   .lsic = settings_.lsic,
                   .convection = convection,
                   .newton = !settings_.newton.picard,
                   .tau_dt = settings_.tau_step.value_or(dt),
                   .viscous_residual = settings_.viscous_residual && convection,
                   .time_weight = settings_.time_weight};
    const double u2 = reference_speed * reference_speed;
    schur_inverse_ = levels == 2 ? (1 / u2) * inverse(slab_schur_matrix(dt, settings_.time_weight))
                                 : Matrix2{1 / (dt * u2), 0, 0, 0};
  }

  [[nodiscard]] Result<double> evaluate(const StepData& data, bool jacobian) override {
    std::fill(residual_.begin(), residual_.end(), 0.0);
    const std::span<const double, n> scale(scale_);
    add_elements<n>(elements_, data, parameters_, scale, residual_, jacobian ? &matrix_ : nullptr);
    open_.template add<n>(data, scale, residual_, jacobian ? &matrix_ : nullptr);
    for (std::size_t i = 0; i < rhs_.size(); ++i) rhs_[i] = -scale_[i % n] * residual_[i];
    slip_.set(data);
    slip_.apply(rhs_);
    for (const Fixed& f : fixed_) rhs_[at(f.row) * n + at(f.component)] = 0;
    if (jacobian) DROGUE_TRY(factor());
    double square = 0;
    for (const double value : rhs_) square += value * value;
    const double norm = std::sqrt(la::sum_over_ranks(square));
    if (!std::isfinite(norm)) return retryable_error("the residual of the flow equations is not finite");
    return norm;
  }

  [[nodiscard]] Result<la::Outcome> solve_and_add(std::span<double> unknowns) override {
    auto outcome = direct_ ? solve_directly() : solve_by_krylov();
    if (!outcome) return outcome.error();
    slip_.apply(solution_);
    la::gather_to_all(ranges_, n, solution_, all_);
    for (std::size_t i = 0; i < unknowns.size(); ++i) unknowns[i] += scale_[i % n] * all_[i];
    return outcome;
  }

 private:
  struct Fixed {
    std::int32_t row = 0;
    int component = 0;
  };

  [[nodiscard]] std::size_t rows() const { return at(pattern_.rows); }

  [[nodiscard]] Result<void> factor() {
    slip_.apply(matrix_);
    for (const Fixed& f : fixed_) matrix_.set_identity_row(f.row, f.component);
    bool regular = false;
    if (direct_) {
      const auto factored = direct_->factor(matrix_);
      if (!factored) return factored.error();
      regular = *factored;
    } else {
      pressure_rows_->copy(matrix_);
      regular = la::on_every_rank(!ilu_->factor(matrix_).has_value());
    }
    if (!regular) return retryable_error("the flow Jacobian is singular: the mesh or the state is unusable");
    return {};
  }

  [[nodiscard]] Result<la::Outcome> solve_directly() {
    DROGUE_TRY(direct_->solve(rhs_, solution_));
    return la::Outcome{true, 1, 0};
  }

  [[nodiscard]] Result<la::Outcome> solve_by_krylov() {
    amg_failed_ = false;
    auto outcome = krylov_->solve(rhs_, solution_);
    if (!outcome) return outcome.error();
    if (!la::on_every_rank(!amg_failed_)) return internal_error("the pressure preconditioner failed");
    return outcome;
  }

  void exchange(std::span<const double> in) {
    std::copy(in.begin(), in.end(), local_.begin());
    exchange_.update(local_);
  }

  void multiply(std::span<const double> in, std::span<double> out) {
    exchange(in);
    matrix_.multiply(local_.data(), out.data());
  }

  void precondition(std::span<const double> r, std::span<double> z) {
    // 1. node blocks
    ilu_->apply(r.data(), z.data());
    // 2. what is left of the pressure rows
    exchange(z);
    pressure_rows_->defect(r.data(), local_.data(), defect_.data());
    // 3. pressure Schur complement
    for (std::size_t q = 0; q < levels; ++q) {
      for (std::size_t i = 0; i < rows(); ++i) {
        level_in_[i] = 0;
        for (std::size_t k = 0; k < levels; ++k)
          level_in_[i] += schur_inverse_[2 * q + k] * defect_[levels * i + k];
      }
      std::fill(level_out_.begin(), level_out_.end(), 0.0);
      amg_failed_ = !amg_->apply(level_in_, level_out_) || amg_failed_;
      for (std::size_t i = 0; i < rows(); ++i) z[n * i + 4 * q + 3] += level_out_[i];
    }
    // 4. fixed rows are those of the identity: no drift of the pinned pressure
    for (const Fixed& f : fixed_) z[at(f.row) * n + at(f.component)] = r[at(f.row) * n + at(f.component)];
  }

  const Settings& settings_;
  std::vector<la::RowRange> ranges_;
  la::RowRange own_;
  la::LocalPattern pattern_;
  la::GhostExchange exchange_;
  LocalElements elements_;
  OpenBoundary open_;
  SlipProjection<n> slip_;
  la::BlockMatrix<n> matrix_;
  std::optional<DirectSolution<n>> direct_; ///< this, or the four after it
  std::optional<la::BlockIlu<n>> ilu_;
  std::optional<la::FourthRows<n>> pressure_rows_;
  std::optional<la::PoissonAmg> amg_;
  std::optional<la::KrylovSolver> krylov_;
  FlowParameters parameters_;
  std::array<double, n> scale_{};
  Matrix2 schur_inverse_{};
  std::vector<Fixed> fixed_;
  std::vector<double> residual_;
  std::vector<double> rhs_;
  std::vector<double> solution_;
  std::vector<double> all_;
  std::vector<double> local_;
  std::vector<double> defect_;
  std::vector<double> level_in_;
  std::vector<double> level_out_;
  bool amg_failed_ = false;
};

template <int n>
Result<std::unique_ptr<FlowSystem>> make(const Settings& settings, const FluidMesh& mesh,
                                         const VelocityConstraints& constraints) {
  auto system = std::make_unique<BlockFlowSystem<n>>(settings, mesh, constraints);
  DROGUE_TRY(system->set_up(mesh, constraints));
  return std::unique_ptr<FlowSystem>(std::move(system));
}

} // namespace

Result<std::unique_ptr<FlowSystem>> make_flow_system(Formulation formulation, const Settings& settings,
                                                     const FluidMesh& mesh,
                                                     const VelocityConstraints& constraints) {
  switch (formulation) {
  case Formulation::semi_discrete:
    return make<4>(settings, mesh, constraints);
  case Formulation::dsd_sst:
    return make<8>(settings, mesh, constraints);
  }
  return internal_error("unknown formulation");
}

} // namespace drogue::fluid
