// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coupler/projection/surface_tree.hpp"

namespace drogue::projection {

/// The common refinement of two line meshes on one element of the first: the parent coordinates -1 = s_0 <
/// s_1 < ... < 1 between which the closest point on the other mesh stays on one of its elements. A quadrature
/// rule on each part integrates products of both meshes' shape functions exactly.
/// @param X  nodes of the element in the coordinates of `other`
[[nodiscard]] std::vector<double> refine_line(mesh::ElementKind kind, const NodeMatrix& X,
                                              const SurfaceTree& other);

/// The Gauss rule of that degree on each part.
[[nodiscard]] std::vector<fem::SurfacePoint> line_quadrature(std::span<const double> breaks, int degree);

} // namespace drogue::projection
