// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/algebraic_extension.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "common/la_krylov/ghost_exchange.hpp"
#include "common/la_krylov/session.hpp"

namespace drogue::mesh_mover {
namespace {

constexpr std::int32_t none = -1;

template <int D>
using Vector = Eigen::Matrix<double, D, 1>;
template <int D>
using Matrix = Eigen::Matrix<double, D, D>;

template <int D>
Vector<D> at(std::span<const double> values, std::int32_t node) {
  return Eigen::Map<const Vector<D>>(&values[3 * static_cast<std::size_t>(node)]);
}

/// Displacement from a position: shift + (gradient) (x - centre).
template <int D>
struct AffineMotion {
  Vector<D> centre = Vector<D>::Zero();
  Vector<D> shift = Vector<D>::Zero();
  Matrix<D> gradient = Matrix<D>::Zero();

  [[nodiscard]] Vector<D> operator()(const Vector<D>& x) const { return shift + gradient * (x - centre); }
};

/// The rotation R that minimises sum |R d - (d + u)|^2, from S = sum (d + u) d^T: R = U V^T without a
/// reflection.
template <int D>
Matrix<D> best_rotation(const Matrix<D>& S) {
  const Eigen::JacobiSVD<Matrix<D>> svd(S, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector<D> sign = Vector<D>::Ones();
  sign[D - 1] = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

/// The best rigid motion, then the best affine remainder; of several the smallest.
template <int D>
AffineMotion<D> fit(std::span<const double> points, std::span<const double> u,
                    std::span<const std::int32_t> nodes) {
  AffineMotion<D> motion;
  const auto n = static_cast<double>(nodes.size());
  for (const std::int32_t node : nodes) {
    motion.centre += at<D>(points, node) / n;
    motion.shift += at<D>(u, node) / n;
  }
  Matrix<D> S = Matrix<D>::Zero(), M = Matrix<D>::Zero();
  for (const std::int32_t node : nodes) {
    const Vector<D> d = at<D>(points, node) - motion.centre;
    S += (d + at<D>(u, node) - motion.shift) * d.transpose();
    M += d * d.transpose();
  }
  motion.gradient = best_rotation<D>(S) - Matrix<D>::Identity();
  // sum (d + u) d^T = S, so that the remainder u - gradient d has the moment S - M - gradient M.
  Eigen::JacobiSVD<Matrix<D>> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  svd.setThreshold(1e-8);
  motion.gradient += svd.solve(Matrix<D>((S - M - motion.gradient * M).transpose())).transpose();
  return motion;
}

} // namespace

NearestSource nearest_sources(const Graph& graph, std::span<const double> points,
                              std::span<const std::int32_t> sources) {
  const std::size_t n = points.size() / 3;
  NearestSource nearest{std::vector<std::int32_t>(n, none),
                        std::vector<double>(n, std::numeric_limits<double>::infinity())};
  struct Candidate {
    double distance;
    std::int32_t node, source;
    bool operator<(const Candidate& other) const { // the largest stands on top of the queue
      return distance != other.distance ? distance > other.distance : node > other.node;
    }
  };
  std::priority_queue<Candidate> queue;
  for (const std::int32_t source : sources) queue.push({0, source, source});
  while (!queue.empty()) {
    const Candidate next = queue.top();
    queue.pop();
    const auto i = static_cast<std::size_t>(next.node);
    if (nearest.node[i] != none) continue;
    nearest.node[i] = next.source;
    nearest.distance[i] = next.distance;
    for (const std::int32_t neighbour : graph.neighbours(i)) {
      const auto j = static_cast<std::size_t>(neighbour);
      if (nearest.node[j] != none) continue;
      const double distance = (at<3>(points, neighbour) - at<3>(points, next.source)).norm();
      if (distance < nearest.distance[j]) {
        nearest.distance[j] = distance;
        queue.push({distance, neighbour, next.source});
      }
    }
  }
  return nearest;
}

AlgebraicExtension::AlgebraicExtension(ExtensionInput input, bool share)
    : input_(std::move(input)),
      dimension_(input_.cells.dimension),
      graph_(lower_pattern(input_.cells, input_.given.size())),
      rank_(share ? la::rank() : 0),
      nearest_bodies_(input_.bodies.size()) {
  const int ranks = share ? la::rank_count() : 1;
  const auto first = [&](int rank) {
    return static_cast<std::int32_t>(input_.given.size() * static_cast<std::size_t>(rank) /
                                     static_cast<std::size_t>(ranks));
  };
  for (int rank = 0; rank < ranks; ++rank) shares_.push_back({first(rank), first(rank + 1)});
  std::vector<bool> is_displaced(input_.given.size(), false);
  for (const auto& body : input_.bodies)
    for (const std::int32_t node : body) is_displaced[static_cast<std::size_t>(node)] = true;
  for (std::size_t i = 0; i < is_displaced.size(); ++i)
    for (std::size_t c = 0; c < static_cast<std::size_t>(dimension_); ++c)
      if (!is_displaced[i] && (input_.given[i] >> c & 1)) others_[c].push_back(static_cast<std::int32_t>(i));
}

Result<void> AlgebraicExtension::prepare(std::span<const double> points) {
  points_.assign(points.begin(), points.end());
  search();
  return {};
}

/// The searches are dealt out to the ranks; each gets to know what the others found.
void AlgebraicExtension::search() {
  struct Job {
    NearestSource* found;
    const std::vector<std::int32_t>* sources;
  };
  std::vector<Job> jobs;
  for (std::size_t b = 0; b < input_.bodies.size(); ++b)
    jobs.push_back({&nearest_bodies_[b], &input_.bodies[b]});
  const auto components = static_cast<std::size_t>(dimension_);
  const auto is_repeated = [&](std::size_t c) { return c > 0 && others_[c] == others_[c - 1]; };
  for (std::size_t c = 0; c < components; ++c)
    if (!is_repeated(c)) jobs.push_back({&nearest_others_[c], &others_[c]});
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    const bool own = k % shares_.size() == static_cast<std::size_t>(rank_);
    NearestSource& found = *jobs[k].found;
    if (own) found = nearest_sources(graph_, points_, *jobs[k].sources);
    if (shares_.size() == 1) continue;
    const std::size_t n = input_.given.size();
    std::vector<double> sum(2 * n, 0.0); // zero on the ranks that did not search
    for (std::size_t i = 0; own && i < n; ++i) {
      sum[i] = found.node[i];
      sum[n + i] = found.distance[i];
    }
    la::sum_over_ranks(sum.data(), static_cast<int>(sum.size()));
    found.node.assign(sum.begin(), sum.begin() + static_cast<std::ptrdiff_t>(n));
    found.distance.assign(sum.begin() + static_cast<std::ptrdiff_t>(n), sum.end());
  }
  for (std::size_t c = 0; c < components; ++c)
    if (is_repeated(c)) nearest_others_[c] = nearest_others_[c - 1];
}

double AlgebraicExtension::weight(double distance) const noexcept {
  return std::pow(std::max(distance, std::numeric_limits<double>::min()), -input_.numbers.weight_exponent);
}

template <int D>
void AlgebraicExtension::extend_own_nodes(std::span<double> u) const {
  std::vector<AffineMotion<D>> fits;
  for (const auto& body : input_.bodies) fits.push_back(fit<D>(points_, u, body));
  const la::RowRange own = shares_[static_cast<std::size_t>(rank_)];
  for (std::int32_t node = own.first; node < own.last; ++node) {
    const auto i = static_cast<std::size_t>(node);
    Vector<D> sum = Vector<D>::Zero(), weights = Vector<D>::Zero();
    for (std::size_t b = 0; b < fits.size(); ++b) {
      const std::int32_t source = nearest_bodies_[b].node[i];
      if (source == none) continue;
      const double w = weight(nearest_bodies_[b].distance[i]);
      const Vector<D> rest = at<D>(u, source) - fits[b](at<D>(points_, source));
      sum += w * (fits[b](at<D>(points_, node)) + rest);
      weights.array() += w;
    }
    for (int c = 0; c < D; ++c) {
      if (input_.given[i] >> c & 1) continue;
      const NearestSource& other = nearest_others_[static_cast<std::size_t>(c)];
      if (other.node[i] != none) {
        const double w = weight(other.distance[i]);
        sum[c] += w * u[3 * static_cast<std::size_t>(other.node[i]) + static_cast<std::size_t>(c)];
        weights[c] += w;
      }
      u[3 * i + static_cast<std::size_t>(c)] = weights[c] > 0 ? sum[c] / weights[c] : 0;
    }
  }
}

Result<SolveOutcome> AlgebraicExtension::extend(std::span<double> u, std::span<const double>) {
  with_dimension(dimension_, [&](auto dimension) { extend_own_nodes<dimension>(u); });
  if (shares_.size() > 1) {
    const la::RowRange own = shares_[static_cast<std::size_t>(rank_)];
    const std::vector<double> found(u.begin() + 3 * own.first, u.begin() + 3 * own.last);
    la::gather_to_all(shares_, 3, found, u);
  }
  return SolveOutcome{true, 0, 0};
}

} // namespace drogue::mesh_mover
