// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/stiffness.hpp"

#include <algorithm>
#include <utility>

#include "mesh_mover/numbering.hpp"

namespace drogue::mesh_mover {
namespace {

constexpr std::uint8_t all_given = 7;

std::vector<std::int32_t> rows_of(const Cells& cells, const std::vector<std::int32_t>& row_of) {
  std::vector<std::int32_t> rows;
  rows.reserve(cells.nodes.size());
  for (const std::int32_t node : cells.nodes) rows.push_back(row_of[static_cast<std::size_t>(node)]);
  return rows;
}

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

Stiffness::Stiffness(const Cells& cells, Mask given, std::vector<double> factors, bool share)
    : cells_(cells),
      factors_(std::move(factors)),
      given_(std::move(given)),
      row_of_(reverse_cuthill_mckee(cells, given_.size())),
      cell_rows_(rows_of(cells, row_of_)),
      given_rows_(given_.size()),
      matrix_(lower_pattern({cells_.dimension, cell_rows_}, given_.size())),
      rows_(share ? SharedRows::among_all_ranks(matrix_) : SharedRows(matrix_)) {
  for (std::size_t i = 0; i < given_.size(); ++i)
    given_rows_[static_cast<std::size_t>(row_of_[i])] = given_[i];
  find_places();
  const int moving = (1 << cells_.dimension) - 1;
  for (std::size_t e = 0; e < cells_.count(); ++e) {
    const auto nodes = cells_.cell(e);
    if (std::any_of(nodes.begin(), nodes.end(), [&](std::int32_t node) {
          return (given_[static_cast<std::size_t>(node)] & moving) != 0;
        }))
      boundary_elements_.emplace_back().index = e;
  }
}

void Stiffness::find_places() {
  const std::size_t n = cells_.nodes_per_cell();
  places_.reserve(cells_.count() * n * (n + 1) / 2);
  std::vector<std::int32_t> first_row;
  for (std::size_t e = 0; e < cells_.count(); ++e)
    first_row.push_back(*std::min_element(&cell_rows_[n * e], &cell_rows_[n * e] + n));
  const auto is_own = [&](std::int32_t row) { return rows_.own().has(static_cast<std::size_t>(row)); };
  for (std::size_t e = 0; e < cells_.count(); ++e)
    if (std::any_of(&cell_rows_[n * e], &cell_rows_[n * e] + n, is_own))
      order_.push_back(static_cast<std::int32_t>(e));
  std::stable_sort(order_.begin(), order_.end(), [&](std::int32_t d, std::int32_t e) {
    return first_row[static_cast<std::size_t>(d)] < first_row[static_cast<std::size_t>(e)];
  });
  for (const std::int32_t cell : order_)
    for (std::size_t e = static_cast<std::size_t>(cell), a = 0; a < n; ++a)
      for (std::size_t b = 0; b <= a; ++b) {
        const auto [low, high] = std::minmax(cell_rows_[n * e + a], cell_rows_[n * e + b]);
        places_.push_back(place_of(matrix_, high, low));
      }
}

void Stiffness::assemble(const PseudoSolid& solid, std::span<const double> points) {
  std::fill(matrix_.values.begin(), matrix_.values.end(), 0.0);
  with_dimension(cells_.dimension, [&](auto d) { assemble_cells<d>(solid, points); });
  solid_ = solid;
  for (std::size_t row = 0; row < given_rows_.size(); ++row)
    for (int c = 0; c < 3; ++c)
      if (given_rows_[row] >> c & 1) matrix_.block(matrix_.diagonal(row))(c, c) = 1;
}

template <int D>
void Stiffness::assemble_cells(const PseudoSolid& solid, std::span<const double> points) {
  for (std::size_t k = 0; k < order_.size(); ++k) add_element<D>(solid, points, k);
  for (BoundaryElement& element : boundary_elements_) {
    const auto geometry = simplex_geometry<D>(points, cells_.cell(element.index));
    element.gradients.template topLeftCorner<D, D + 1>() = geometry.gradients;
    element.weight = weight<D>(solid, geometry.jacobian, element.index);
  }
}

template <int D>
void Stiffness::add_element(const PseudoSolid& solid, std::span<const double> points, std::size_t k) {
  constexpr std::size_t n = D + 1;
  const auto e = static_cast<std::size_t>(order_[k]);
  const auto geometry = simplex_geometry<D>(points, cells_.cell(e));
  const double factor = weight<D>(solid, geometry.jacobian, e);
  const std::int32_t* rows = &cell_rows_[n * e];
  const std::int32_t* place = &places_[n * (n + 1) / 2 * k];
  for (int a = 0; a <= D; ++a)
    for (int b = 0; b <= a; ++b, ++place) {
      const auto [row, column] = rows[a] >= rows[b] ? std::pair(a, b) : std::pair(b, a);
      const std::uint8_t given_row = given_rows_[static_cast<std::size_t>(rows[row])];
      const std::uint8_t given_column = given_rows_[static_cast<std::size_t>(rows[column])];
      if (given_row == all_given || given_column == all_given) continue;
      auto block = stiffness_block<D>(solid, geometry, factor, row, column);
      for (int c = 0; c < D; ++c) {
        if (given_row >> c & 1) block.row(c).setZero();
        if (given_column >> c & 1) block.col(c).setZero();
      }
      matrix_.block(static_cast<std::size_t>(*place)).template topLeftCorner<D, D>() += block;
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
    const auto nodes = cells_.cell(element.index);
    Eigen::Matrix<double, 3, 4> u_g = Eigen::Matrix<double, 3, 4>::Zero();
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      const auto node = static_cast<std::size_t>(nodes[a]);
      for (int c = 0; c < cells_.dimension; ++c)
        if (is_given(node, c)) u_g(c, static_cast<int>(a)) = u[3 * node + static_cast<std::size_t>(c)];
    }
    const auto force = element_force(solid_, element.gradients, element.weight, u_g);
    for (std::size_t a = 0; a < nodes.size(); ++a)
      Eigen::Map<Eigen::Vector3d>(&load[3 * static_cast<std::size_t>(nodes[a])]) -=
          force.col(static_cast<int>(a));
  }
  for (std::size_t i = 0; i < given_.size(); ++i)
    for (int c = 0; c < 3; ++c)
      if (is_given(i, c)) load[3 * i + static_cast<std::size_t>(c)] = u[3 * i + static_cast<std::size_t>(c)];
}

} // namespace drogue::mesh_mover
