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

Stiffness::Stiffness(std::span<const std::int32_t> tets, Mask given)
    : tets_(tets), given_(std::move(given)), matrix_(lower_pattern(tets, given_.size())) {
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
        const auto [low, high] = std::minmax(tets_[4 * e + a], tets_[4 * e + b]);
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
  for (std::size_t i = 0; i < given_.size(); ++i)
    for (int c = 0; c < 3; ++c)
      if (is_given(i, c)) matrix_.block(matrix_.diagonal(i))(c, c) = 1;
}

void Stiffness::add_element(const PseudoSolid& solid, std::span<const double> points, std::size_t e) {
  const auto nodes = tets_.subspan(4 * e, 4);
  const TetGeometry geometry = tet_geometry(points, nodes);
  const double weight = stiffness_weight(solid, geometry.jacobian);
  const std::int32_t* place = &places_[10 * e];
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b <= a; ++b, ++place) {
      const bool a_is_row = nodes[static_cast<std::size_t>(a)] >= nodes[static_cast<std::size_t>(b)];
      const int row = a_is_row ? a : b;
      const int column = a_is_row ? b : a;
      const std::uint8_t given_row = given_[static_cast<std::size_t>(nodes[static_cast<std::size_t>(row)])];
      const std::uint8_t given_column =
          given_[static_cast<std::size_t>(nodes[static_cast<std::size_t>(column)])];
      if (given_row == all_given || given_column == all_given) continue;
      Eigen::Matrix3d block = stiffness_block(solid, geometry, weight, row, column);
      for (int c = 0; c < 3; ++c) {
        if (given_row >> c & 1) block.row(c).setZero();
        if (given_column >> c & 1) block.col(c).setZero();
      }
      matrix_.block(static_cast<std::size_t>(*place)) += block;
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
