// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/coarse_space.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <Eigen/Geometry>

#include "mesh_mover/graph.hpp"

namespace drogue::mesh_mover {
namespace {

constexpr std::int32_t none = -1;
constexpr std::uint8_t all_given = 7;
/// Columns of Z an aggregate: translations along, and rotations about the axes.
constexpr std::size_t modes = 6;
/// Relative addition to the diagonal for rotations, which an aggregate in a line or of one node does not
/// have.
constexpr double rotation_shift = 1e-6;
/// Nodes of an aggregate, about.
constexpr std::size_t aggregate_size = 150;

} // namespace

CoarseSpace::CoarseSpace(const SymmetricBlocks<double>& A, const Mask& given, const SharedRows& rows)
    : A_(A), given_(given), rows_(rows) {
  gather(A);
  find_pattern(A);
  rhs_.resize(modes * static_cast<std::size_t>(count_));
  arms_.resize(3 * A.rows());
}

/// Breadth-first from the first node that is left, until the aggregate is full. Seeds are taken beside the
/// aggregates that exist, so that few small ones remain.
void CoarseSpace::gather(const SymmetricBlocks<double>& A) {
  const Graph graph(A);
  const std::size_t n = A.rows();
  aggregate_.assign(n, none);
  std::vector<std::int32_t> seeds; // a queue of nodes beside aggregates
  std::size_t next_seed = 0;
  std::size_t next_node = 0;
  std::vector<std::int32_t> front;
  const auto is_open = [&](std::size_t i) { return aggregate_[i] == none && given_[i] != all_given; };
  while (true) {
    while (next_seed < seeds.size() && !is_open(static_cast<std::size_t>(seeds[next_seed]))) ++next_seed;
    std::int32_t seed = none;
    if (next_seed < seeds.size()) {
      seed = seeds[next_seed];
    } else {
      while (next_node < n && !is_open(next_node)) ++next_node;
      if (next_node == n) return;
      seed = static_cast<std::int32_t>(next_node);
    }
    front.assign(1, seed);
    aggregate_[static_cast<std::size_t>(seed)] = count_;
    for (std::size_t k = 0; k < front.size(); ++k) {
      const auto i = static_cast<std::size_t>(front[k]);
      for (const std::int32_t neighbour : graph.neighbours(i)) {
        const auto j = static_cast<std::size_t>(neighbour);
        if (!is_open(j)) continue;
        if (front.size() < aggregate_size) {
          aggregate_[j] = count_;
          front.push_back(neighbour);
        } else {
          seeds.push_back(neighbour);
        }
      }
    }
    ++count_;
  }
}

void CoarseSpace::find_pattern(const SymmetricBlocks<double>& A) {
  std::vector<std::set<std::int32_t>> rows(static_cast<std::size_t>(count_));
  const auto pair_of = [&](std::size_t i, std::size_t k) {
    const std::int32_t a = aggregate_[i];
    const std::int32_t b = aggregate_[static_cast<std::size_t>(A.column[k])];
    return std::pair(std::max(a, b), std::min(a, b));
  };
  for (std::size_t i = 0; i < A.rows(); ++i)
    for (std::size_t k = A.begin(i); k <= A.diagonal(i); ++k)
      if (const auto [row, column] = pair_of(i, k); column != none)
        rows[static_cast<std::size_t>(row)].insert(column);
  coarse_.row_start.assign(1, 0);
  for (const auto& row : rows) {
    coarse_.column.insert(coarse_.column.end(), row.begin(), row.end());
    coarse_.row_start.push_back(static_cast<std::int32_t>(coarse_.column.size()));
  }
  coarse_.values.resize(modes * modes * coarse_.column.size());
  places_.assign(A.column.size(), none);
  for (std::size_t i = 0; i < A.rows(); ++i)
    for (std::size_t k = A.begin(i); k <= A.diagonal(i); ++k)
      if (const auto [row, column] = pair_of(i, k); column != none)
        places_[k] = place_of(coarse_, row, column);
}

void CoarseSpace::find_arms(std::span<const double> positions) {
  const auto n = static_cast<std::size_t>(count_);
  std::vector<double> centre(3 * n, 0.0), radius(n, 0.0), size(n, 0.0);
  const auto visit = [&](auto&& each) {
    for (std::size_t i = 0; i < aggregate_.size(); ++i)
      if (aggregate_[i] != none) each(i, static_cast<std::size_t>(aggregate_[i]));
  };
  visit([&](std::size_t i, std::size_t g) {
    size[g] += 1;
    for (std::size_t c = 0; c < 3; ++c) centre[3 * g + c] += positions[3 * i + c];
  });
  visit([&](std::size_t i, std::size_t g) {
    for (std::size_t c = 0; c < 3; ++c) {
      arms_[3 * i + c] = positions[3 * i + c] - centre[3 * g + c] / size[g];
      radius[g] = std::max(radius[g], std::abs(arms_[3 * i + c]));
    }
  });
  visit([&](std::size_t i, std::size_t g) {
    for (std::size_t c = 0; c < 3; ++c) arms_[3 * i + c] = size[g] > 1 ? arms_[3 * i + c] / radius[g] : 0;
  });
}

/// Columns: the node's displacement by a rotation about x, y and z.
Eigen::Matrix3d CoarseSpace::rotations(std::size_t row) const noexcept {
  const double* d = &arms_[3 * row];
  Eigen::Matrix3d R;
  R << 0, d[2], -d[1], -d[2], 0, d[0], d[1], -d[0], 0;
  return R;
}

/// E = sum of Z_i^T A_ij Z_j with Z_i = [I, R_i]; every rank has the lower blocks of its own rows.
void CoarseSpace::sum_blocks() {
  using Block = SymmetricBlocks<double, 6>::Block;
  std::fill(coarse_.values.begin(), coarse_.values.end(), 0.0);
  for (std::size_t i = rows_.own().first; i < rows_.own().last; ++i) {
    if (aggregate_[i] == none) continue;
    const Eigen::Matrix3d R_i = rotations(i).transpose();
    for (std::size_t k = A_.begin(i); k <= A_.diagonal(i); ++k) {
      if (places_[k] == none) continue;
      const auto j = static_cast<std::size_t>(A_.column[k]);
      Eigen::Matrix3d K = A_.block(k);
      if (i == j) // the identity of the given components is no stiffness
        for (int c = 0; c < 3; ++c)
          if (given_[i] >> c & 1) K(c, c) = 0;
      const Eigen::Matrix3d KR = K * rotations(j);
      Block Z;
      Z << K, KR, R_i * K, R_i * KR;
      auto E = coarse_.block(static_cast<std::size_t>(places_[k]));
      // Both (i, j) and (j, i) of A add to the lower triangle of E.
      if (aggregate_[i] > aggregate_[j])
        E += Z;
      else if (aggregate_[i] < aggregate_[j])
        E += Z.transpose();
      else if (i == j)
        E += Z;
      else
        E += Z + Z.transpose();
    }
  }
  rows_.sum(coarse_.values);
}

Result<void> CoarseSpace::factor(std::span<const double> positions) {
  find_arms(positions);
  sum_blocks();
  const auto n = static_cast<int>(modes);
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t row = 0; row < coarse_.rows(); ++row) {
    auto D = coarse_.block(coarse_.diagonal(row));
    for (int c = 0; c < n; ++c) {
      if (c >= 3) D(c, c) *= 1 + rotation_shift;
      if (D(c, c) == 0) D(c, c) = 1; // a motion that the aggregate does not have
    }
    for (std::size_t k = coarse_.begin(row); k <= coarse_.diagonal(row); ++k)
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) // the solver reads the upper triangle
          entries.emplace_back(n * coarse_.column[k] + b, n * static_cast<int>(row) + a,
                               coarse_.block(k)(a, b));
  }
  la::SparseMatrix E(n * count_, n * count_);
  E.setFromTriplets(entries.begin(), entries.end());
  auto factored = solver_.factor(E);
  if (!factored) return factored.error();
  if (!*factored) return internal_error("the coarse matrix of the mesh motion is not positive definite");
  return {};
}

Result<void> CoarseSpace::add(std::span<const double> r, std::span<double> z) {
  using Vector = Eigen::Vector3d;
  std::fill(rhs_.begin(), rhs_.end(), 0.0);
  for (std::size_t i = rows_.own().first; i < rows_.own().last; ++i) {
    if (aggregate_[i] == none) continue;
    Vector force;
    for (int c = 0; c < 3; ++c) force[c] = given_[i] >> c & 1 ? 0 : r[3 * i + static_cast<std::size_t>(c)];
    double* rhs = &rhs_[modes * static_cast<std::size_t>(aggregate_[i])];
    Eigen::Map<Vector>{rhs} += force;
    Eigen::Map<Vector>{rhs + 3} += Eigen::Map<const Vector>(&arms_[3 * i]).cross(force);
  }
  rows_.sum(rhs_);
  DROGUE_TRY(solver_.solve(rhs_, rhs_));
  for (std::size_t i = rows_.own().first; i < rows_.own().last; ++i) {
    if (aggregate_[i] == none) continue;
    const double* motion = &rhs_[modes * static_cast<std::size_t>(aggregate_[i])];
    const Vector u = Eigen::Map<const Vector>(motion) +
                     Eigen::Map<const Vector>(motion + 3).cross(Eigen::Map<const Vector>(&arms_[3 * i]));
    for (std::size_t c = 0; c < 3; ++c)
      if (!(given_[i] >> c & 1)) z[3 * i + c] += u[static_cast<int>(c)];
  }
  return {};
}

} // namespace drogue::mesh_mover
