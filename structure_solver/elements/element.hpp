// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace drogue::structure {

/// What a kernel gives back for one element with `Nodes` nodes.
///
/// A kernel is a type with
///   static constexpr mesh::ElementKind kind
///   static constexpr int nodes            number of nodes
///   struct Material                       constants of the group, the same for all its elements
///   struct Reference                      what an element keeps of its reference configuration
///   static Reference reference(X, ...)    X: reference positions, one column a node
///   static void evaluate(const Reference&, const Material&, const Positions& x, bool tangent, Response&)
///   static NodalMass lumped_mass(const Reference&, const Material&)   positive, with the right total
///   static bool regular(X, const Reference&)                          false: nothing can be computed with it
///   static constexpr const char* irregular                            what is wrong then, in words
/// evaluate() gives the element's share of the residual r = f_int - f_ext and its derivative from one and the
/// same evaluation of strain and stress. A new element is one header and one line in elements/registry.hpp.
template <int Nodes>
struct Response {
  using Positions = Eigen::Matrix<double, 3, Nodes>;
  /// Column a: force on node a [force]. Aligned, like the tangent: where a vectorised sum starts, and so its
  /// rounding, must not depend on the place of the response in memory.
  alignas(64) Positions force;
  /// d force / d x, 3 x 3 blocks by (row node, column node) [force/length]; only when asked for.
  alignas(64) Eigen::Matrix<double, 3 * Nodes, 3 * Nodes> tangent;
  /// Stored energy [force length]; zero for loads.
  double energy = 0;

  void clear(bool with_tangent) noexcept {
    force.setZero();
    if (with_tangent) tangent.setZero();
    energy = 0;
  }
};

} // namespace drogue::structure
