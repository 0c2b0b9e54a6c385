// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"

/// Meshes of the flow benchmarks, the same to the bit whenever they are made.
namespace drogue::fluid::test {

/// Wanted edge length at a point of the plane [length].
using PlaneSize = std::function<double(double x, double y)>;

/// A rectangle with an obstacle, in triangles; groups fluid, inflow (x low), outflow (x high), bottom, top,
/// obstacle.
struct Channel {
  std::array<double, 2> low{};
  std::array<double, 2> high{};
  std::array<double, 2> centre{}; ///< of the cylinder
  double radius = 0;
  /// Point of a rigid plate's end and its thickness: a plate from the cylinder downstream; thickness 0: none.
  double plate_end = 0;
  double plate_thickness = 0;
  bool plate_apart = false; ///< the plate's sides make a group `plate` of their own
};
[[nodiscard]] mesh::Mesh channel_mesh(const Channel& channel, const PlaneSize& size);

/// Edge lengths about the obstacle of flag_in_channel.
struct FlagSizes {
  double wall = 0;   ///< on the obstacle
  double growth = 0; ///< with the distance
  double bulk = 0;   ///< the longest
};
/// Half of the wall's size at the flag's end, half of the longest in the wake.
[[nodiscard]] PlaneSize flag_sizes(const FlagSizes& sizes);
/// The cylinder with a flag of Turek and Hron (2006) in its channel 2.5 x 0.41.
[[nodiscard]] mesh::Mesh flag_in_channel(const FlagSizes& sizes, bool flag_apart);
/// The same with a mesh that is its own mirror image in the flag's axis y = 0.2, but for the strip 0.4 < y <
/// 0.41: the lift, small beside the drag, is not that of the mesh. Groups as of channel_mesh.
[[nodiscard]] mesh::Mesh mirrored_flag_in_channel(const FlagSizes& sizes, bool flag_apart = false);

/// `fine` on the distance 0, growing by `growth` length a length of distance, at most `coarse`.
[[nodiscard]] double graded(double distance, double fine, double growth, double coarse);

/// A ring of triangles round a circle of `radius`, `around` edges, the radial size growing by a constant
/// factor from `first` up to the `outer` radius. Groups fluid, cylinder, outer. half: its upper half, with
/// the group symmetry.
[[nodiscard]] mesh::Mesh ring_mesh(double radius, double outer, int around, double first, bool half);

/// A plane mesh pulled along z over the levels z: every triangle's prisms in three tetrahedra. Groups: the
/// volume and the sides have the names of the plane's, the ends are `z0` and `z1`.
[[nodiscard]] mesh::Mesh extruded(const mesh::Mesh& plane, const std::vector<double>& z);

/// A quarter (y > 0, z > 0) of the shell between a sphere and a larger one, tetrahedra: `n` edges along a
/// quarter of a great circle, the radial size growing by a constant factor from `first`. Groups fluid,
/// sphere, symmetry_y, symmetry_z, and of the outer sphere inflow (x < 0) and outflow.
[[nodiscard]] mesh::Mesh sphere_mesh(double radius, double outer, int n, double first);

} // namespace drogue::fluid::test
