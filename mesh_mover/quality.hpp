// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "mesh_mover/cells.hpp"

namespace drogue::mesh_mover {

/// Shape of one cell.
struct CellShape {
  /// dimension! times the signed volume (in two dimensions: area) [length^dimension].
  double jacobian = 0;
  /// l_max^dimension / jacobian: proportional to the aspect ratio of [stein2003]. Infinite when inverted.
  double aspect = 0;
  /// 12 (3 V)^(2/3) / (sum of squared edges), in two dimensions 4 sqrt(3) A / (sum of squared edges): 1 for
  /// the regular simplex, 0 when flat, and 0 by definition when inverted.
  double mean_ratio = 0;
  /// Cosine of the smallest angle between two faces (in two dimensions: edges); 1 when inverted.
  double cosine = 1;
};

/// `points` {n, 3}, `nodes` {dimension + 1}.
[[nodiscard]] CellShape cell_shape(int dimension, std::span<const double> points,
                                   std::span<const std::int32_t> nodes) noexcept;

/// How good a moved mesh is. Elements are numbered in mesh order, from 0.
struct Quality {
  /// Smallest and largest element volume as a fraction of the initial one.
  double min_volume_ratio = 1;
  double max_volume_ratio = 1;
  /// Largest |log2 (V / V0)| and |log2 (AR / AR0)| over the elements [stein2003]; infinite with an inverted
  /// one.
  double f_A = 0;
  double f_AR = 0;
  /// The worst mean ratio, and the mean over all elements.
  double worst_mean_ratio = 1;
  double mean_mean_ratio = 1;
  /// The smallest dihedral angle, in two dimensions the smallest angle [degrees].
  double smallest_angle = 0;
  /// The elements of the smallest volume ratio, the worst mean ratio and the largest f_AR, and the first
  /// two's centroids.
  std::int32_t min_volume_element = 0;
  std::int32_t worst_element = 0;
  std::int32_t f_AR_element = 0;
  std::array<double, 3> min_volume_place{};
  std::array<double, 3> worst_place{};
};

/// What a mesh must keep. The defaults ask for nothing but positive volumes.
struct Limits {
  double min_volume_ratio = 0;
  double mean_ratio = 0;
  double angle = 0; ///< degrees
  double f_A = std::numeric_limits<double>::infinity();
  double f_AR = std::numeric_limits<double>::infinity();
};

/// What an element's change is measured against.
struct InitialShapes {
  std::vector<double> jacobians;       ///< {m}, positive
  std::vector<double> squared_aspects; ///< {m}
};

/// Errors (ErrorKind::config): no cells; a node without a cell; a cell without positive volume.
[[nodiscard]] Result<InitialShapes> initial_shapes(std::span<const double> points, const Cells& cells);

/// With default_threads(), fewer for small meshes; the mean of the mean ratios depends on their number in its
/// last digits. @pre the mesh has cells
[[nodiscard]] Quality assess(std::span<const double> points, const Cells& cells,
                             const InitialShapes& initial);

/// Values below which 1, 10 and 50 % of the elements lie.
struct Percentiles {
  double p1 = 0;
  double p10 = 0;
  double p50 = 0;
};
struct Distribution {
  Percentiles mean_ratio;
  Percentiles angle; ///< of the smallest angle of each element [degrees]
};
[[nodiscard]] Distribution distribution(std::span<const double> points, const Cells& cells);

/// The first limit a mesh breaks, with the element and its place; empty when it keeps all.
[[nodiscard]] std::string broken_limit(const Quality& quality, const Limits& limits, const Cells& cells,
                                       std::span<const double> points);

} // namespace drogue::mesh_mover
