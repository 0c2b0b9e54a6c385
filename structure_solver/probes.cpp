// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/probes.hpp"

#include <limits>

#include <Eigen/Dense>
#include <fmt/format.h>

namespace drogue::structure {
namespace {

/// Keeps the nearest candidate.
class Nearest {
 public:
  Nearest(const Model& model, const Eigen::Vector3d& position) : model_(model), position_(position) {}

  void node(std::int32_t a) { offer({a}, {1.0}); }

  void segment(std::int32_t a, std::int32_t b) {
    const Eigen::Vector3d A = at(a), d = at(b) - A;
    const double length = d.squaredNorm(), s = length > 0 ? (position_ - A).dot(d) / length : 0;
    if (s > 0 && s < 1) offer({a, b}, {1 - s, s});
  }

  void triangle(std::int32_t a, std::int32_t b, std::int32_t c) {
    const Eigen::Vector3d A = at(a), p = at(b) - A, q = at(c) - A, r = position_ - A;
    Eigen::Matrix2d gram;
    gram << p.dot(p), p.dot(q), p.dot(q), q.dot(q);
    if (!(gram.determinant() > 0)) return;
    const Eigen::Vector2d st = gram.inverse() * Eigen::Vector2d(p.dot(r), q.dot(r));
    if (st.minCoeff() >= 0 && st.sum() <= 1) offer({a, b, c}, {1 - st.sum(), st(0), st(1)});
    segment(a, b);
    segment(b, c);
    segment(c, a);
  }

  std::vector<std::int32_t> nodes;
  std::vector<double> weights;
  double distance = std::numeric_limits<double>::infinity();

 private:
  [[nodiscard]] Eigen::Vector3d at(std::int32_t node) const {
    return Eigen::Map<const Eigen::Vector3d>(&model_.mesh.points[3 * static_cast<std::size_t>(node)]);
  }
  void offer(std::vector<std::int32_t> candidate, std::vector<double> weight) {
    Eigen::Vector3d X = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < candidate.size(); ++k) X += weight[k] * at(candidate[k]);
    const double to_candidate = (X - position_).norm();
    if (!(to_candidate < distance)) return;
    distance = to_candidate;
    nodes = std::move(candidate);
    weights = std::move(weight);
  }

  const Model& model_;
  Eigen::Vector3d position_;
};

void visit(const mesh::ElementBlock& block, Nearest& nearest) {
  // corner, middle, corner, ... around a nine-node quadrilateral
  constexpr std::array<std::size_t, 9> ring = {0, 4, 1, 5, 2, 6, 3, 7, 0};
  for (std::int32_t e = 0; e < block.count(); ++e) {
    const auto n = block.element(e);
    if (block.kind == mesh::ElementKind::line2) nearest.segment(n[0], n[1]);
    if (block.kind == mesh::ElementKind::tri3) nearest.triangle(n[0], n[1], n[2]);
    if (block.kind == mesh::ElementKind::tri6) {
      nearest.triangle(n[0], n[3], n[5]);
      nearest.triangle(n[3], n[1], n[4]);
      nearest.triangle(n[5], n[4], n[2]);
      nearest.triangle(n[3], n[4], n[5]);
    }
    if (block.kind == mesh::ElementKind::quad4) {
      nearest.triangle(n[0], n[1], n[2]);
      nearest.triangle(n[0], n[2], n[3]);
    }
    if (block.kind == mesh::ElementKind::quad9)
      for (std::size_t k = 0; k < 8; ++k) nearest.triangle(n[ring[k]], n[ring[k + 1]], n[8]);
  }
}

} // namespace

std::array<double, 3> ProbePoint::operator()(std::span<const double> values) const {
  std::array<double, 3> sum{};
  for (std::size_t k = 0; k < nodes.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c)
      sum[c] += weights[k] * values[3 * static_cast<std::size_t>(nodes[k]) + c];
  return sum;
}

ProbePoint locate(const Model& model, const ProbeSettings& probe) {
  Nearest nearest(model, {probe.position[0], probe.position[1], probe.position[2]});
  for (std::int32_t node = 0; node < model.mesh.node_count(); ++node) nearest.node(node);
  for (const mesh::ElementBlock& block : model.mesh.blocks) visit(block, nearest);
  return {probe.name, std::move(nearest.nodes), std::move(nearest.weights), nearest.distance};
}

void check_probes(const Settings& settings, const Model& model, config::Report& report) {
  constexpr double allowed = 0.01; // of the structure's size
  const Eigen::Map<const Eigen::Matrix3Xd> X(model.mesh.points.data(), 3, model.mesh.node_count());
  const double size = (X.rowwise().maxCoeff() - X.rowwise().minCoeff()).norm();
  for (std::size_t i = 0; i < settings.probes.size(); ++i) {
    const ProbeSettings& probe = settings.probes[i];
    const ProbePoint point = locate(model, probe);
    if (point.distance <= allowed * size) continue;
    const auto nearest = point(model.mesh.points);
    report.error(
        settings.source.where(fmt::format("probe[{}]", i)),
        fmt::format("probe \"{}\" at ({}, {}, {}) is {:.3g} away from the structure; the nearest point of "
                    "the reference configuration is ({:.6g}, {:.6g}, {:.6g})",
                    probe.name, probe.position[0], probe.position[1], probe.position[2], point.distance,
                    nearest[0], nearest[1], nearest[2]));
  }
}

} // namespace drogue::structure
