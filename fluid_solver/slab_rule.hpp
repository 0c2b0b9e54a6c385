// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace drogue::fluid {

/// Gauss points of a slab in time: positions theta in (0, 1), weights of sum 1. Two integrate products of
/// linear functions on a fixed mesh exactly (degree 3), three what a moving mesh adds (degree 5).
template <int points>
struct SlabRule;

/// The end of the step: semi-discrete.
template <>
struct SlabRule<1> {
  double theta[1] = {1.0};
  double weight[1] = {1.0};
};

template <>
struct SlabRule<2> {
  double theta[2] = {0.21132486540518711775, 0.78867513459481288225};
  double weight[2] = {0.5, 0.5};
};

template <>
struct SlabRule<3> {
  double theta[3] = {0.11270166537925831148, 0.5, 0.88729833462074168852};
  double weight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
};

} // namespace drogue::fluid
