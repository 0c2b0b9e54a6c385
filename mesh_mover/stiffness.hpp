// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh_mover/cells.hpp"
#include "mesh_mover/coarse_space.hpp"
#include "mesh_mover/pseudo_solid.hpp"

namespace drogue::mesh_mover {

/// The stiffness matrix of the pseudo-solid with the given components eliminated symmetrically: their rows
/// and columns are those of the identity, so that the matrix stays symmetric and positive definite.
///
/// Displacements and loads are in the order of the nodes; the rows of the matrix have a numbering of their
/// own (numbering.hpp), to_rows() and to_nodes() translate. In two dimensions the third component of every
/// node is given.
class Stiffness {
 public:
  /// Finds the sparsity and the place of every element's blocks. `cells` must outlive this object.
  /// @param factors of the elements' stiffness {m}; empty: one
  /// @param share the rows with the other ranks: only the elements of the own rows are assembled, so that
  /// their rows and
  ///              columns are complete
  Stiffness(const Cells& cells, Mask given, std::vector<double> factors = {}, bool share = false);

  /// Assembles on the mesh `points` {n, 3}. @pre all elements have positive volume
  void assemble(const PseudoSolid& solid, std::span<const double> points);

  /// load = - K_fg u_g on the free components and u_g on the given ones, for the last assembled matrix.
  /// `u` and `load` {n, 3}; only the given entries of `u` are read.
  void boundary_load(std::span<const double> u, std::span<double> load) const;

  [[nodiscard]] const SymmetricBlocks<double>& matrix() const { return matrix_; }
  [[nodiscard]] const SharedRows& rows() const { return rows_; }
  /// The given components in the order of the rows.
  [[nodiscard]] const Mask& given_rows() const { return given_rows_; }
  [[nodiscard]] bool is_given(std::size_t node, int component) const {
    return (given_[node] >> component & 1) != 0;
  }
  /// Three values a node to three values a row, and back.
  void to_rows(std::span<const double> by_node, std::span<double> by_row) const;
  void to_nodes(std::span<const double> by_row, std::span<double> by_node) const;

 private:
  struct BoundaryElement {
    std::size_t index = 0;
    Eigen::Matrix<double, 3, 4> gradients = Eigen::Matrix<double, 3, 4>::Zero(); // those of its nodes first
    double weight = 0;
  };
  void find_places();
  template <int D>
  void assemble_cells(const PseudoSolid& solid, std::span<const double> points);
  template <int D>
  void add_element(const PseudoSolid& solid, std::span<const double> points, std::size_t k);
  template <int D>
  [[nodiscard]] double weight(const PseudoSolid& solid, double jacobian, std::size_t e) const noexcept {
    return stiffness_weight<D>(solid, jacobian) * (factors_.empty() ? 1 : factors_[e]);
  }

  const Cells& cells_;
  std::vector<double> factors_;
  Mask given_;
  std::vector<std::int32_t> row_of_; // of each node
  std::vector<std::int32_t>
      order_; // the elements of the own rows by their first rows, so that memory is visited in order
  std::vector<std::int32_t>
      cell_rows_; // {m, dimension + 1}, in mesh order: rows of the nodes of every element
  Mask given_rows_;
  SymmetricBlocks<double> matrix_;
  SharedRows rows_;
  std::vector<std::int32_t> places_; // where the blocks of nodes a >= b of every element stand, in order_
  std::vector<BoundaryElement> boundary_elements_; // those with a given component
  PseudoSolid solid_;                              // of the last assembly
};

} // namespace drogue::mesh_mover
