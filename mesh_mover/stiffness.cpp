// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/stiffness.hpp"

#include <algorithm>
#include <cassert>

namespace drogue::mesh_mover {
namespace {

constexpr std::uint8_t all_given = 7;

/// Nodal forces of one element: f_a = weight sigma(u) g_a, columns a.
Eigen::Matrix<double, 3, 4> element_force(const PseudoSolid& solid,
                                          const Eigen::Matrix<double, 3, 4>& gradients, double weight,
                                          const Eigen::Matrix<double, 3, 4>& u) noexcept {
  const Eigen::Matrix3d grad_u = u * gradients.transpose();
  Eigen::Matrix3d sigma = solid.mu * (grad_u + grad_u.transpose());
  sigma.diagonal().array() += solid.lambda * grad_u.trace();
  return weight * sigma * gradients;
}

} // namespace

Stiffness::Stiffness(std::span<const std::int32_t> tets, Mask given) : tets_(tets), given_(std::move(given)) {
  find_pattern();
  find_places();
  for (std::size_t e = 0; e < tets_.size() / 4; ++e)
    if (std::any_of(&tets_[4 * e], &tets_[4 * e] + 4,
                    [&](std::int32_t node) { return given_[static_cast<std::size_t>(node)] != 0; }))
      boundary_elements_.emplace_back().index = e;
}

void Stiffness::find_pattern() {
  const std::size_t n = given_.size();
  std::vector<std::int32_t> first(n + 1, 0);
  for (const std::int32_t node : tets_) ++first[static_cast<std::size_t>(node) + 1];
  for (std::size_t i = 0; i < n; ++i) first[i + 1] += first[i];
  std::vector<std::int32_t> elements(tets_.size());
  std::vector<std::int32_t> next(first.begin(), first.end() - 1);
  for (std::size_t k = 0; k < tets_.size(); ++k)
    elements[static_cast<std::size_t>(next[static_cast<std::size_t>(tets_[k])]++)] =
        static_cast<std::int32_t>(k / 4);

  pattern_.row_start.assign(1, 0);
  std::vector<std::int32_t> row;
  for (std::size_t i = 0; i < n; ++i) {
    row.assign(1, static_cast<std::int32_t>(i));
    for (std::int32_t k = first[i]; k < first[i + 1]; ++k) {
      const std::int32_t* nodes = &tets_[4 * static_cast<std::size_t>(elements[static_cast<std::size_t>(k)])];
      row.insert(row.end(), nodes, nodes + 4);
    }
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    pattern_.column.insert(pattern_.column.end(), row.begin(), row.end());
    pattern_.row_start.push_back(static_cast<std::int32_t>(pattern_.column.size()));
  }
}

void Stiffness::find_places() {
  places_.resize(4 * tets_.size());
  for (std::size_t e = 0; e < tets_.size() / 4; ++e)
    for (std::size_t a = 0; a < 4; ++a) {
      const auto row = static_cast<std::size_t>(tets_[4 * e + a]);
      const auto begin = pattern_.column.begin() + pattern_.row_start[row];
      const auto end = pattern_.column.begin() + pattern_.row_start[row + 1];
      for (std::size_t b = 0; b < 4; ++b)
        places_[16 * e + 4 * a + b] = static_cast<std::int32_t>(
            std::lower_bound(begin, end, tets_[4 * e + b]) - pattern_.column.begin());
    }
}

void Stiffness::assemble(const PseudoSolid& solid, std::span<const double> points, std::span<double> values) {
  std::fill(values.begin(), values.end(), 0.0);
  for (std::size_t e = 0; e < tets_.size() / 4; ++e) add_element(solid, points, e, values);
  solid_ = solid;
  for (BoundaryElement& element : boundary_elements_) {
    const TetGeometry geometry = tet_geometry(points, tets_.subspan(4 * element.index, 4));
    element.gradients = geometry.gradients;
    element.weight = stiffness_weight(solid, geometry.jacobian);
  }
  for (std::size_t i = 0; i < given_.size(); ++i) {
    if (given_[i] == 0) continue;
    const auto begin = pattern_.column.begin() + pattern_.row_start[i];
    const auto end = pattern_.column.begin() + pattern_.row_start[i + 1];
    const auto diagonal =
        std::lower_bound(begin, end, static_cast<std::int32_t>(i)) - pattern_.column.begin();
    for (int c = 0; c < 3; ++c)
      if (is_given(i, c))
        values[9 * static_cast<std::size_t>(diagonal) + static_cast<std::size_t>(4 * c)] = 1;
  }
}

void Stiffness::add_element(const PseudoSolid& solid, std::span<const double> points, std::size_t e,
                            std::span<double> values) const {
  const auto nodes = tets_.subspan(4 * e, 4);
  const TetGeometry geometry = tet_geometry(points, nodes);
  const double weight = stiffness_weight(solid, geometry.jacobian);
  for (int a = 0; a < 4; ++a) {
    const std::uint8_t given_a = given_[static_cast<std::size_t>(nodes[static_cast<std::size_t>(a)])];
    if (given_a == all_given) continue;
    for (int b = 0; b < 4; ++b) {
      const std::uint8_t given_b = given_[static_cast<std::size_t>(nodes[static_cast<std::size_t>(b)])];
      if (given_b == all_given) continue;
      Eigen::Matrix3d block = stiffness_block(solid, geometry, weight, a, b);
      for (int c = 0; c < 3; ++c) {
        if (given_a >> c & 1) block.row(c).setZero();
        if (given_b >> c & 1) block.col(c).setZero();
      }
      const auto place = static_cast<std::size_t>(places_[16 * e + static_cast<std::size_t>(4 * a + b)]);
      Eigen::Map<Eigen::Matrix3d>(&values[9 * place]) += block;
    }
  }
}

void Stiffness::boundary_load(std::span<const double> u, std::span<double> load) const {
  std::fill(load.begin(), load.end(), 0.0);
  for (const BoundaryElement& element : boundary_elements_) {
    const auto nodes = tets_.subspan(4 * element.index, 4);
    Eigen::Matrix<double, 3, 4> u_g;
    for (int a = 0; a < 4; ++a) {
      const auto node = static_cast<std::size_t>(nodes[static_cast<std::size_t>(a)]);
      for (int c = 0; c < 3; ++c)
        u_g(c, a) = is_given(node, c) ? u[3 * node + static_cast<std::size_t>(c)] : 0;
    }
    const auto force = element_force(solid_, element.gradients, element.weight, u_g);
    for (int a = 0; a < 4; ++a)
      Eigen::Map<Eigen::Vector3d>(&load[3 * static_cast<std::size_t>(nodes[static_cast<std::size_t>(a)])]) -=
          force.col(a);
  }
  for (std::size_t i = 0; i < given_.size(); ++i)
    for (int c = 0; c < 3; ++c)
      if (is_given(i, c)) load[3 * i + static_cast<std::size_t>(c)] = u[3 * i + static_cast<std::size_t>(c)];
}

} // namespace drogue::mesh_mover
