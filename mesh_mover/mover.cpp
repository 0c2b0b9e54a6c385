// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/mover.hpp"

#include <algorithm>

namespace drogue::mesh_mover {

Result<std::unique_ptr<MeshMover>> MeshMover::create(mesh::Mesh mesh, const Settings& settings) {
  auto cells = cells_of(mesh);
  auto initial = mesh_mover::initial_shapes(mesh.points, cells);
  if (!initial) return initial.error();
  auto motion = BoundaryMotion::create(mesh, cells.dimension, settings.boundaries);
  if (!motion) return motion.error();
  return std::unique_ptr<MeshMover>(
      new MeshMover(std::move(mesh), settings, std::move(cells), std::move(*motion), std::move(*initial)));
}

MeshMover::MeshMover(mesh::Mesh mesh, const Settings& settings, Cells cells, BoundaryMotion motion,
                     InitialShapes initial)
    : mesh_(std::move(mesh)),
      settings_(settings),
      cells_(std::move(cells)),
      motion_(std::move(motion)),
      initial_(std::move(initial)),
      extension_(make_extension(settings_, cells_, motion_, initial_.jacobians)),
      u_n_(mesh_.points.size(), 0.0),
      increment_n_(u_n_),
      u_np1_(u_n_),
      points_np1_(mesh_.points),
      target_(u_n_),
      w_(u_n_),
      increment_(u_n_) {
  const auto base = mesh_.node_fields.find(start_displacement_name);
  if (base == mesh_.node_fields.end() || base->second.components != 3) return;
  base_ = base->second.values;
  origin_ = mesh_.points;
  for (std::size_t i = 0; i < origin_.size(); ++i) origin_[i] -= base_[i];
}

/// function(i) for every given entry i of a nodal array {nodes, 3}.
template <class Function>
void MeshMover::for_each_given(Function&& function) const {
  const Mask& given = motion_.given();
  for (std::size_t node = 0; node < given.size(); ++node)
    for (std::size_t c = 0; c < 3; ++c)
      if (given[node] >> c & 1) function(3 * node + c);
}

Result<void> MeshMover::prepare_base() {
  if (is_prepared_) return {};
  std::vector<double> base = mesh_.points;
  if (!from_initial())
    for (std::size_t i = 0; i < base.size(); ++i) base[i] += u_n_[i];
  DROGUE_TRY(extension_->prepare(base));
  is_prepared_ = true;
  return {};
}

Result<void> MeshMover::begin_step(double time_step) {
  time_step_ = time_step;
  parts_ = 1;
  if (!from_initial()) is_prepared_ = false;
  DROGUE_TRY(prepare_base());
  start_value();
  return {};
}

void MeshMover::start_value() {
  const double ratio = time_step_n_ > 0 ? time_step_ / time_step_n_ : 0;
  for (std::size_t i = 0; i < w_.size(); ++i) {
    w_[i] = ratio * increment_n_[i];
    if (from_initial()) w_[i] += u_n_[i];
  }
}

void MeshMover::set_displacement(std::size_t i, double u) {
  u_np1_[i] = u;
  points_np1_[i] = mesh_.points[i] + u;
}

Result<SolveReport> MeshMover::judge(SolveReport report) const {
  report.quality = assess(points_np1_, cells_, initial_);
  const std::string broken = broken_limit(report.quality, settings_.stop, cells_, points_np1_);
  if (!broken.empty()) return retryable_error("{}; try a smaller step", broken);
  report.warning = broken_limit(report.quality, settings_.warn, cells_, points_np1_);
  return report;
}

Result<SolveReport> MeshMover::move_at_once() {
  DROGUE_TRY(prepare_base());
  bool moves = false;
  for_each_given([&](std::size_t i) {
    increment_[i] = target_[i] - u_n_[i];
    w_[i] = from_initial() ? target_[i] : increment_[i];
    moves = moves || increment_[i] != 0;
  });
  SolveReport report;
  if (moves) {
    const auto outcome = extension_->extend(w_, increment_);
    if (!outcome) return outcome.error();
    if (!outcome->converged)
      return retryable_error(
          "the mesh motion did not converge: relative residual {:.3g} after {} iterations (tolerance {:.3g})",
          outcome->residual, outcome->iterations, settings_.tolerance);
    report.iterations = outcome->iterations;
    report.residual = outcome->residual;
  } else if (from_initial()) { // the boundary is where it was at t_n
    w_ = u_n_;
  } else {
    std::fill(w_.begin(), w_.end(), 0.0);
  }
  for (std::size_t i = 0; i < w_.size(); ++i) set_displacement(i, from_initial() ? w_[i] : u_n_[i] + w_[i]);
  return judge(std::move(report));
}

Result<SolveReport> MeshMover::move_in(int parts) {
  is_prepared_ = false; // the extension is prepared for intermediate meshes
  const std::vector<double> start = from_initial() ? std::vector<double>(u_n_.size(), 0.0) : u_n_;
  for (std::size_t i = 0; i < start.size(); ++i) set_displacement(i, start[i]);
  for_each_given([&](std::size_t i) { increment_[i] = (target_[i] - start[i]) / parts; });
  std::vector<double> w(start.size(), 0.0);
  SolveReport report;
  report.sub_increments = parts;
  for (int part = 1; part <= parts; ++part) {
    DROGUE_TRY(extension_->prepare(points_np1_));
    for_each_given([&](std::size_t i) { w[i] = increment_[i]; });
    const auto outcome = extension_->extend(w, increment_);
    if (!outcome) return outcome.error();
    if (!outcome->converged)
      return retryable_error("the mesh motion did not converge in part {} of {}: relative residual {:.3g}",
                             part, parts, outcome->residual);
    report.iterations += outcome->iterations;
    report.residual = std::max(report.residual, outcome->residual);
    for (std::size_t i = 0; i < w.size(); ++i) set_displacement(i, u_np1_[i] + w[i]);
    if (part < parts && !(assess(points_np1_, cells_, initial_).min_volume_ratio > 0)) return judge(report);
  }
  for_each_given([&](std::size_t i) { set_displacement(i, target_[i]); });
  return judge(std::move(report));
}

void MeshMover::set_target(const BoundaryInput& input) {
  motion_.evaluate(input, is_replacement() ? origin_ : mesh_.points, target_);
  if (is_replacement()) for_each_given([&](std::size_t i) { target_[i] -= base_[i]; });
}

std::vector<double> MeshMover::displacement_since_start() const {
  std::vector<double> u = u_np1_;
  if (is_replacement())
    for (std::size_t i = 0; i < u.size(); ++i) u[i] += base_[i];
  return u;
}

Result<SolveReport> MeshMover::solve(const BoundaryInput& input) {
  set_target(input);
  auto report = parts_ == 1 ? move_at_once() : move_in(parts_);
  while (!report && report.error().retryable && 2 * parts_ <= settings_.max_sub_increments) {
    parts_ *= 2;
    report = move_in(parts_);
  }
  return report;
}

void MeshMover::commit() {
  for (std::size_t i = 0; i < u_n_.size(); ++i) increment_n_[i] = u_np1_[i] - u_n_[i];
  u_n_ = u_np1_;
  time_step_n_ = time_step_;
}

void MeshMover::rollback() {
  for (std::size_t i = 0; i < u_n_.size(); ++i) set_displacement(i, u_n_[i]);
}

Quality MeshMover::current_quality() const {
  return assess(points_np1_, cells_, initial_);
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
