// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fluid_solver/fluid_mesh.hpp"

namespace drogue::fluid {

/// Orthonormal directions in which a node's velocity is held by free slip at an instant.
struct SlipDirections {
  std::int32_t node = 0;
  int count = 0;
  double n[3][3] = {};

  /// v without its parts along the directions.
  void project(double* v) const noexcept {
    for (int k = 0; k < count; ++k) {
      const double along = n[k][0] * v[0] + n[k][1] * v[1] + n[k][2] * v[2];
      for (int d = 0; d < 3; ++d) v[d] -= along * n[k][d];
    }
  }
};

/// Free slip on planes of any orientation and on curved surfaces by consistent nodal normals
///   n_a = int N_a n dGamma,   u_a . n_a = int N_a w . n dGamma
/// [engelman1982], w the wall's velocity where the boundary is a wall, else zero. Summed over the nodes it
/// says that nothing flows through the surface; and a constant pressure pushes no node along it.
///
/// Faces round a node whose normals differ by less than the feature angle, directly or from one to the next,
/// share one normal; a node on the edge of a box has two, in its corner three. Which faces belong together is
/// decided once, on the mesh of the file; the normals follow the mesh.
class SlipWalls {
 public:
  /// A face of the mesh where the flow slips.
  struct Face {
    BoundaryFace face;
    bool wall = false; ///< its motion pushes the fluid
  };
  /// No slip anywhere.
  SlipWalls() = default;
  /// fixed {3 n}: components that other conditions hold. Nodes with all three take no part.
  SlipWalls(std::span<const Face> faces, std::span<const char> fixed, std::span<const double> points,
            double feature_angle);

  /// Ascending.
  [[nodiscard]] std::span<const std::int32_t> nodes() const { return nodes_; }

  /// Normals on `points` {n, 3}, one entry a node; puts the held parts of the velocities
  /// unknowns[stride i + offset + d] right, in which the `fixed` components are already set.
  [[nodiscard]] std::vector<SlipDirections> apply(std::span<const double> points,
                                                  std::span<const double> wall_velocity,
                                                  std::span<double> unknowns, std::size_t stride,
                                                  std::size_t offset) const;

 private:
  /// A face at a node; those of one normal follow each other.
  struct Part {
    Face at;
    bool last = false; ///< of its normal
  };
  [[nodiscard]] SlipDirections hold(std::size_t index, std::span<const double> points, const double* wall,
                                    double* u) const;

  std::vector<std::int32_t> nodes_;
  std::vector<std::size_t> start_; ///< {nodes + 1} into parts_
  std::vector<Part> parts_;
  std::vector<char> fixed_; ///< {nodes, 3}
};

} // namespace drogue::fluid
