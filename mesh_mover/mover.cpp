// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/mover.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace drogue::mesh_mover {
namespace {

/// Below this fraction of the load the residual is rounding.
constexpr double rounding = 1e-13;

std::vector<std::int32_t> all_tets(const mesh::Mesh& mesh) {
  std::vector<std::int32_t> tets;
  for (const auto& block : mesh.blocks)
    if (block.kind == mesh::ElementKind::tet4)
      tets.insert(tets.end(), block.nodes.begin(), block.nodes.end());
  return tets;
}

double mean(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Euclidean norm of the free entries.
double free_norm(const Stiffness& stiffness, std::span<const double> f) {
  double sum = 0;
  for (std::size_t i = 0; i < f.size() / 3; ++i)
    for (int c = 0; c < 3; ++c)
      if (!stiffness.is_given(i, c))
        sum += f[3 * i + static_cast<std::size_t>(c)] * f[3 * i + static_cast<std::size_t>(c)];
  return std::sqrt(sum);
}

} // namespace

Result<std::unique_ptr<MeshMover>> MeshMover::create(mesh::Mesh mesh, const Settings& settings) {
  auto tets = all_tets(mesh);
  auto jacobians = positive_jacobians(mesh.points, tets);
  if (!jacobians) return jacobians.error();
  auto motion = BoundaryMotion::create(mesh, settings.boundaries);
  if (!motion) return motion.error();
  return std::unique_ptr<MeshMover>(
      new MeshMover(std::move(mesh), settings, std::move(*motion), std::move(tets), std::move(*jacobians)));
}

MeshMover::MeshMover(mesh::Mesh mesh, const Settings& settings, BoundaryMotion motion,
                     std::vector<std::int32_t> tets, std::vector<double> jacobians)
    : mesh_(std::move(mesh)),
      settings_(settings),
      motion_(std::move(motion)),
      tets_(std::move(tets)),
      initial_jacobians_(std::move(jacobians)),
      solid_(pseudo_solid(settings.poisson_ratio, settings.stiffening_exponent, mean(initial_jacobians_))),
      stiffness_(tets_, motion_.given()),
      solver_(stiffness_.matrix(), stiffness_.given_rows()),
      u_n_(mesh_.points.size(), 0.0),
      increment_n_(u_n_),
      u_np1_(u_n_),
      points_np1_(mesh_.points),
      w_(u_n_),
      load_(u_n_),
      work_(u_n_),
      load_rows_(u_n_),
      w_rows_(u_n_) {}

Result<void> MeshMover::prepare(std::span<const double> points) {
  stiffness_.assemble(solid_, points);
  DROGUE_TRY(solver_.update());
  is_prepared_ = true;
  return {};
}

Result<void> MeshMover::begin_step(double time_step) {
  time_step_ = time_step;
  if (settings_.increment == Increment::from_last_step)
    DROGUE_TRY(prepare(points_np1_));
  else if (!is_prepared_)
    DROGUE_TRY(prepare(mesh_.points));
  start_value();
  return {};
}

void MeshMover::start_value() {
  const double ratio = time_step_n_ > 0 ? time_step_ / time_step_n_ : 0;
  for (std::size_t i = 0; i < w_.size(); ++i) {
    w_[i] = ratio * increment_n_[i];
    if (settings_.increment == Increment::from_initial) w_[i] += u_n_[i];
  }
}

double MeshMover::load_of_increment() {
  // The given entries of w_ hold the boundary values of this iterate.
  if (settings_.increment == Increment::from_last_step) return free_norm(stiffness_, load_);
  for (std::size_t i = 0; i < w_.size(); ++i) u_np1_[i] = w_[i] - u_n_[i];
  stiffness_.boundary_load(u_np1_, work_);
  return free_norm(stiffness_, work_);
}

Result<SolveOutcome> MeshMover::relax(const BoundaryInput& input, double& reference) {
  // 1. boundary values of the unknown
  motion_.evaluate(input, mesh_.points, w_);
  if (settings_.increment == Increment::from_last_step)
    for (std::size_t i = 0; i < w_.size() / 3; ++i)
      for (int c = 0; c < 3; ++c)
        if (stiffness_.is_given(i, c))
          w_[3 * i + static_cast<std::size_t>(c)] -= u_n_[3 * i + static_cast<std::size_t>(c)];
  // 2. load, and the norm against which the residual is measured
  stiffness_.boundary_load(w_, load_);
  reference = load_of_increment();
  if (reference == 0) { // the boundary is where it was at t_n
    if (settings_.increment == Increment::from_last_step)
      std::fill(w_.begin(), w_.end(), 0.0);
    else
      w_ = u_n_;
    return SolveOutcome{true, 0, 0};
  }
  // 3. the linear system, in the numbering of the matrix
  const double tolerance = std::max(settings_.tolerance * reference, rounding * free_norm(stiffness_, load_));
  stiffness_.to_rows(load_, load_rows_);
  stiffness_.to_rows(w_, w_rows_);
  auto outcome = solver_.solve(load_rows_, w_rows_, tolerance, settings_.max_iterations);
  stiffness_.to_nodes(w_rows_, w_);
  return outcome;
}

Result<SolveReport> MeshMover::solve(const BoundaryInput& input) {
  double reference = 0;
  const auto outcome = relax(input, reference);
  if (!outcome) return outcome.error();
  const bool incremental = settings_.increment == Increment::from_last_step;
  for (std::size_t i = 0; i < w_.size(); ++i) {
    u_np1_[i] = incremental ? u_n_[i] + w_[i] : w_[i];
    points_np1_[i] = mesh_.points[i] + u_np1_[i];
  }
  SolveReport report;
  report.iterations = outcome->iterations;
  report.residual = reference > 0 ? outcome->residual / reference : 0;
  if (!outcome->converged)
    return retryable_error(
        "the mesh motion did not converge: relative residual {:.3g} after {} iterations (tolerance "
        "{:.3g})",
        report.residual, report.iterations, settings_.tolerance);
  report.quality = assess(points_np1_, tets_, initial_jacobians_);
  DROGUE_TRY(accept(report.quality, settings_.smallest_volume_ratio));
  return report;
}

void MeshMover::commit() {
  for (std::size_t i = 0; i < u_n_.size(); ++i) increment_n_[i] = u_np1_[i] - u_n_[i];
  u_n_ = u_np1_;
  time_step_n_ = time_step_;
}

void MeshMover::rollback() {
  u_np1_ = u_n_;
  for (std::size_t i = 0; i < u_n_.size(); ++i) points_np1_[i] = mesh_.points[i] + u_n_[i];
}

Quality MeshMover::current_quality() const {
  return assess(points_np1_, tets_, initial_jacobians_);
}

void MeshMover::save(io::State& state) const {
  const auto n = static_cast<std::uint64_t>(mesh_.node_count());
  state.add("displacement", {n, 3}, u_n_);
  state.add("increment", {n, 3}, increment_n_);
  state.add("time_step", {1}, {time_step_n_});
}

Result<void> MeshMover::load(const io::State& state) {
  const auto* displacement = state.find("displacement");
  const auto* increment = state.find("increment");
  const auto* time_step = state.find("time_step");
  if (!displacement || !increment || !time_step || displacement->values.size() != u_n_.size() ||
      increment->values.size() != u_n_.size() || time_step->values.size() != 1)
    return config_error("the state of mesh_mover lacks displacement or increment of {} nodes, or time_step",
                        mesh_.node_count());
  u_n_ = displacement->values;
  increment_n_ = increment->values;
  time_step_n_ = time_step->values.front();
  rollback();
  return {};
}

} // namespace drogue::mesh_mover
