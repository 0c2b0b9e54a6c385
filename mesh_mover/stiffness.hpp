// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh_mover/pseudo_solid.hpp"

namespace drogue::mesh_mover {

/// Bit i of an entry: component i of the node's displacement is given. Shape {nodes}.
using Mask = std::vector<std::uint8_t>;

/// Which 3 x 3 blocks a sparse matrix stores: block compressed sparse rows, columns sorted.
struct BlockPattern {
  std::vector<std::int32_t> row_start;
  std::vector<std::int32_t> column;

  [[nodiscard]] std::int32_t rows() const { return static_cast<std::int32_t>(row_start.size()) - 1; }
};

/// The stiffness matrix of the pseudo-solid with the given components eliminated symmetrically: their rows
/// and columns are those of the identity, so that the matrix stays symmetric and positive definite.
class Stiffness {
 public:
  /// Finds the sparsity and the place of every element's blocks. `tets` {m, 4} must outlive this object.
  Stiffness(std::span<const std::int32_t> tets, Mask given);

  /// Assembles on the mesh `points` {n, 3}. `values` {blocks, 3, 3}: the blocks of the pattern, each
  /// column-major.
  /// @pre all elements have positive volume
  void assemble(const PseudoSolid& solid, std::span<const double> points, std::span<double> values);

  /// load = - K_fg u_g on the free components and u_g on the given ones, for the last assembled matrix.
  /// `u` and `load` {n, 3}; only the given entries of `u` are read.
  void boundary_load(std::span<const double> u, std::span<double> load) const;

  [[nodiscard]] const BlockPattern& pattern() const { return pattern_; }
  [[nodiscard]] const Mask& given() const { return given_; }
  [[nodiscard]] bool is_given(std::size_t node, int component) const {
    return (given_[node] >> component & 1) != 0;
  }

 private:
  struct BoundaryElement {
    std::size_t index = 0;
    Eigen::Matrix<double, 3, 4> gradients = Eigen::Matrix<double, 3, 4>::Zero();
    double weight = 0;
  };
  void find_pattern();
  void find_places();
  void add_element(const PseudoSolid& solid, std::span<const double> points, std::size_t e,
                   std::span<double> values) const;

  std::span<const std::int32_t> tets_;
  Mask given_;
  BlockPattern pattern_;
  std::vector<std::int32_t> places_;               // {m, 4, 4}: index of the block of nodes a, b
  std::vector<BoundaryElement> boundary_elements_; // those with a given component
  PseudoSolid solid_;                              // of the last assembly
};

} // namespace drogue::mesh_mover
