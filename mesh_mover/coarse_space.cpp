// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/coarse_space.hpp"

#include <algorithm>
#include <set>

#include "mesh_mover/graph.hpp"

namespace drogue::mesh_mover {
namespace {

constexpr std::int32_t none = -1;
constexpr std::uint8_t all_given = 7;
/// Nodes of an aggregate, about.
constexpr std::size_t aggregate_size = 50;

} // namespace

CoarseSpace::CoarseSpace(const SymmetricBlocks<double>& A, const Mask& given) : given_(given) {
  gather(A);
  find_pattern(A);
  rhs_.resize(3 * static_cast<std::size_t>(count_));
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
  coarse_.values.resize(9 * coarse_.column.size());
  places_.assign(A.column.size(), none);
  for (std::size_t i = 0; i < A.rows(); ++i)
    for (std::size_t k = A.begin(i); k <= A.diagonal(i); ++k)
      if (const auto [row, column] = pair_of(i, k); column != none)
        places_[k] = place_of(coarse_, row, column);
}

Result<void> CoarseSpace::factor(const SymmetricBlocks<double>& A) {
  std::fill(coarse_.values.begin(), coarse_.values.end(), 0.0);
  for (std::size_t i = 0; i < A.rows(); ++i) {
    for (std::size_t k = A.begin(i); k <= A.diagonal(i); ++k) {
      if (places_[k] == none) continue;
      const auto j = static_cast<std::size_t>(A.column[k]);
      auto E = coarse_.block(static_cast<std::size_t>(places_[k]));
      Eigen::Matrix3d K = A.block(k);
      if (i == j) // the identity of the given components is no stiffness
        for (int c = 0; c < 3; ++c)
          if (given_[i] >> c & 1) K(c, c) = 0;
      // Both (i, j) and (j, i) of A add to the lower triangle of E.
      if (aggregate_[i] > aggregate_[j])
        E += K;
      else if (aggregate_[i] < aggregate_[j])
        E += K.transpose();
      else
        E += i == j ? K : Eigen::Matrix3d(K + K.transpose());
    }
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t row = 0; row < coarse_.rows(); ++row) {
    auto D = coarse_.block(coarse_.diagonal(row));
    for (int c = 0; c < 3; ++c)
      if (D(c, c) == 0) D(c, c) = 1; // a component that is given in the whole aggregate
    for (std::size_t k = coarse_.begin(row); k <= coarse_.diagonal(row); ++k)
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) // the solver reads the upper triangle
          entries.emplace_back(3 * coarse_.column[k] + b, 3 * static_cast<int>(row) + a,
                               coarse_.block(k)(a, b));
  }
  la::SparseMatrix E(3 * count_, 3 * count_);
  E.setFromTriplets(entries.begin(), entries.end());
  auto factored = solver_.factor(E);
  if (!factored) return factored.error();
  if (!*factored) return internal_error("the coarse matrix of the mesh motion is not positive definite");
  return {};
}

Result<void> CoarseSpace::add(std::span<const double> r, std::span<double> z) {
  std::fill(rhs_.begin(), rhs_.end(), 0.0);
  const auto visit = [&](auto&& each) {
    for (std::size_t i = 0; i < aggregate_.size(); ++i) {
      if (aggregate_[i] == none) continue;
      for (std::size_t c = 0; c < 3; ++c)
        if (!(given_[i] >> c & 1)) each(3 * i + c, 3 * static_cast<std::size_t>(aggregate_[i]) + c);
    }
  };
  visit([&](std::size_t fine, std::size_t coarse) { rhs_[coarse] += r[fine]; });
  DROGUE_TRY(solver_.solve(rhs_, rhs_));
  visit([&](std::size_t fine, std::size_t coarse) { z[fine] += rhs_[coarse]; });
  return {};
}

} // namespace drogue::mesh_mover
