// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <limits>

#include "common/la_krylov/node_graph.hpp"
#include "mesh_mover/extension.hpp"
#include "mesh_mover/graph.hpp"

namespace drogue::mesh_mover {

/// For every node the nearest of some sources, and its distance [length].
struct NearestSource {
  std::vector<std::int32_t> node; // -1: none can be reached
  std::vector<double> distance;
};

/// Sources are handed on from neighbour to neighbour, nearest first, so that those beyond a wall do not
/// count.
[[nodiscard]] NearestSource nearest_sources(const Graph& graph, std::span<const double> points,
                                            std::span<const std::int32_t> sources);

/// The mesh without an elastic problem, for motions that are known beforehand [stein2001, "Mesh-Moving
/// Strategy"]:
///     u(x) = sum_b w_b(x) (A_b(x) + r_b(x)) + w_o(x) u_o(x),   w_k = d_k^-p / sum_l d_l^-p.
/// Every displaced boundary b carries its own motion into the mesh: A_b is the rigid motion that fits it
/// best, with the affine remainder that fits best; r_b is what the nearest of its nodes does beyond that. u_o
/// is what the nearest other node does whose displacement is given, component by component. d_k are the
/// distances to them.
///
/// Affine motions of the boundary are reproduced where every boundary is displaced and reaches into all
/// directions, rigid motions also by boundaries that are flat. Costs as much as reading the mesh; gives no
/// guarantee against inversion where a boundary bends much.
class AlgebraicExtension : public Extension {
 public:
  /// @param share share the searches and the nodes with the other ranks
  AlgebraicExtension(ExtensionInput input, bool share);

  [[nodiscard]] Result<void> prepare(std::span<const double> points) override;
  [[nodiscard]] Result<SolveOutcome> extend(std::span<double> u, std::span<const double> increment) override;

 private:
  [[nodiscard]] double weight(double distance) const noexcept;
  void search();
  template <int D>
  void extend_own_nodes(std::span<double> u) const;

  ExtensionInput input_;
  int dimension_;
  Graph graph_;
  std::vector<la::RowRange> shares_; // of the nodes, a rank each
  int rank_ = 0;
  std::vector<double> points_;
  std::vector<NearestSource> nearest_bodies_;
  std::array<std::vector<std::int32_t>, 3> others_; // nodes not displaced whose component is given
  std::array<NearestSource, 3> nearest_others_;
};

} // namespace drogue::mesh_mover
