// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.hpp"

namespace drogue::mesh_mover {

/// How good a moved mesh is. Elements are numbered in mesh order, from 0.
struct Quality {
  /// Smallest and largest element volume as a fraction of the initial one.
  double min_volume_ratio = 1;
  double max_volume_ratio = 1;
  /// Mean ratio 12 (3 V)^(2/3) / (sum of squared edge lengths): 1 for the regular tetrahedron, 0 when flat,
  /// and 0 by definition when inverted. The worst and the mean over all elements.
  double worst_mean_ratio = 1;
  double mean_mean_ratio = 1;
  /// The elements of the smallest volume ratio and of the worst mean ratio, and their centroids.
  std::int32_t min_volume_element = 0;
  std::int32_t worst_element = 0;
  std::array<double, 3> min_volume_place{};
  std::array<double, 3> worst_place{};
};

/// Mean ratio of one tetrahedron [0..1]. `points` {n, 3}, `nodes` {4}.
[[nodiscard]] double mean_ratio(std::span<const double> points, std::span<const std::int32_t> nodes) noexcept;

/// `tets` {m, 4}; `initial_jacobians` {m}, positive. @pre m > 0
[[nodiscard]] Quality assess(std::span<const double> points, std::span<const std::int32_t> tets,
                             std::span<const double> initial_jacobians) noexcept;

/// Six-fold volumes of all elements {m}. Errors (ErrorKind::config): an element without positive volume.
[[nodiscard]] Result<std::vector<double>> positive_jacobians(std::span<const double> points,
                                                             std::span<const std::int32_t> tets);

/// Refuses (retryable) a mesh with an element below `smallest_volume_ratio` or inverted; says which and
/// where.
[[nodiscard]] Result<void> accept(const Quality& quality, double smallest_volume_ratio);

} // namespace drogue::mesh_mover
