// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>

namespace drogue::fluid {

/// A quadrature point of a boundary face: values of the shape functions of its nodes, and its share of the
/// area.
struct FacePoint {
  double N[3] = {};
  double share = 0;
};

/// Exact for degree 2 at least: the middles of a triangle's sides, two Gauss points on an edge.
[[nodiscard]] inline std::span<const FacePoint> face_rule(std::size_t corners) {
  static constexpr double near = 0.78867513459481288225; // (1 + 1/sqrt 3) / 2
  static constexpr FacePoint edge[2] = {{{near, 1 - near, 0}, 0.5}, {{1 - near, near, 0}, 0.5}};
  static constexpr FacePoint triangle[3] = {
      {{0.5, 0.5, 0}, 1.0 / 3}, {{0, 0.5, 0.5}, 1.0 / 3}, {{0.5, 0, 0.5}, 1.0 / 3}};
  return corners == 2 ? std::span<const FacePoint>(edge) : std::span<const FacePoint>(triangle);
}

} // namespace drogue::fluid
