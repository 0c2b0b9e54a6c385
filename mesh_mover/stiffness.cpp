// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/stiffness.hpp"

#include <algorithm>
#include <utility>

#include "mesh_mover/numbering.hpp"

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

Stiffness::Stiffness(std::span<const std::int32_t> tets, Mask given)
    : tets_(tets),
      given_(std::move(given)),
      row_of_(reverse_cuthill_mckee(tets, given_.size())),
      tet_rows_(tets.size()),
      given_rows_(given_.size()) {
  for (std::size_t k = 0; k < tets_.size(); ++k) tet_rows_[k] = row_of_[static_cast<std::size_t>(tets_[k])];
  for (std::size_t i = 0; i < given_.size(); ++i)
    given_rows_[static_cast<std::size_t>(row_of_[i])] = given_[i];
  matrix_ = lower_pattern(tet_rows_, given_.size());
  find_places();
  for (std::size_t e = 0; e < tets_.size() / 4; ++e)
    if (std::any_of(&tets_[4 * e], &tets_[4 * e] + 4,
                    [&](std::int32_t node) { return given_[static_cast<std::size_t>(node)] != 0; }))
      boundary_elements_.emplace_back().index = e;
}

void Stiffness::find_places() {
  places_.reserve(10 * tets_.size() / 4);
  for (std::size_t e = 0; e < tets_.size() / 4; ++e)
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b <= a; ++b) {
        const auto [low, high] = std::minmax(tet_rows_[4 * e + a], tet_rows_[4 * e + b]);
        places_.push_back(place_of(matrix_, high, low));
      }
}

void Stiffness::assemble(const PseudoSolid& solid, std::span<const double> points) {
  std::fill(matrix_.values.begin(), matrix_.values.end(), 0.0);
  for (std::size_t e = 0; e < tets_.size() / 4; ++e) add_element(solid, points, e);
  solid_ = solid;
  for (BoundaryElement& element : boundary_elements_) {
    const TetGeometry geometry = tet_geometry(points, tets_.subspan(4 * element.index, 4));
    element.gradients = geometry.gradients;
    element.weight = stiffness_weight(solid, geometry.jacobian);
  }
  for (std::size_t row = 0; row < given_rows_.size(); ++row)
    for (int c = 0; c < 3; ++c)
      if (given_rows_[row] >> c & 1) matrix_.block(matrix_.diagonal(row))(c, c) = 1;
}

void Stiffness::add_element(const PseudoSolid& solid, std::span<const double> points, std::size_t e) {
  const TetGeometry geometry = tet_geometry(points, tets_.subspan(4 * e, 4));
  const double weight = stiffness_weight(solid, geometry.jacobian);
  const std::int32_t* rows = &tet_rows_[4 * e];
  const std::int32_t* place = &places_[10 * e];
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b <= a; ++b, ++place) {
      const auto [row, column] = rows[a] >= rows[b] ? std::pair(a, b) : std::pair(b, a);
      const std::uint8_t given_row = given_rows_[static_cast<std::size_t>(rows[row])];
      const std::uint8_t given_column = given_rows_[static_cast<std::size_t>(rows[column])];
      if (given_row == all_given || given_column == all_given) continue;
      Eigen::Matrix3d block = stiffness_block(solid, geometry, weight, row, column);
      for (int c = 0; c < 3; ++c) {
        if (given_row >> c & 1) block.row(c).setZero();
        if (given_column >> c & 1) block.col(c).setZero();
      }
      matrix_.block(static_cast<std::size_t>(*place)) += block;
    }
}

void Stiffness::to_rows(std::span<const double> by_node, std::span<double> by_row) const {
  for (std::size_t i = 0; i < row_of_.size(); ++i)
    std::copy_n(&by_node[3 * i], 3, &by_row[3 * static_cast<std::size_t>(row_of_[i])]);
}

void Stiffness::to_nodes(std::span<const double> by_row, std::span<double> by_node) const {
  for (std::size_t i = 0; i < row_of_.size(); ++i)
    std::copy_n(&by_row[3 * static_cast<std::size_t>(row_of_[i])], 3, &by_node[3 * i]);
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
