// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/membrane_volume.hpp"

#include <algorithm>
#include <utility>

#include "common/meshing/checks.hpp"
#include "common/meshing/membrane_checks.hpp"
#include "common/meshing/quality.hpp"

namespace drogue::meshing {
namespace {

/// Factors of the element sizes that are tried one after the other until no dihedral angle is below
/// good_angle: a little difference gives another mesh, and few meshes have a sliver that cannot be smoothed.
constexpr double size_factors[] = {1, 0.995, 1.005, 0.99, 1.01};
constexpr double good_angle = 8; ///< degrees

Result<MembraneVolume> mesh_once(const Box& box, const std::vector<Point>& points,
                                 const std::vector<Triangle>& membrane, const SizeFunction& size) {
  Result<TetMesh> meshed = mesh_box(box, points, membrane, size);
  if (!meshed) return meshed.error();
  MembraneVolume result{.mesh = std::move(*meshed), .split = {}, .smoothing_moves = 0, .doubling = {}};
  result.split = split_bridges(result.mesh);
  result.smoothing_moves = smooth_bad_tets(result.mesh, 0.25, 8);
  result.smoothing_moves += smooth_bad_tets(result.mesh, 0.35, 4);
  return result;
}

double smallest_angle_of(const TetMesh& m) {
  double smallest = 180;
  for (const Tet& tet : m.tets) smallest = std::min(smallest, smallest_dihedral_angle(m.points, tet));
  return smallest;
}

} // namespace

Result<MembraneVolume> mesh_membrane_volume(const Box& box, const std::vector<Point>& points,
                                            const std::vector<Triangle>& membrane, const SizeRule& sizes,
                                            const std::string& upper, const std::string& lower) {
  DROGUE_TRY(check_membrane(points, membrane));
  const SizeField size(sizes, points, membrane);
  Result<MembraneVolume> result = numerical_error("no mesh was made");
  double best = -1;
  for (const double factor : size_factors) {
    Result<MembraneVolume> made =
        mesh_once(box, points, membrane, [&](const Point& x) { return factor * size(x); });
    if (!made && factor == 1) return made.error();
    const double angle = made ? smallest_angle_of(made->mesh) : -1;
    if (angle > best) {
      best = angle;
      result = std::move(made);
    }
    if (best >= good_angle) break;
  }
  Result<DoublingSummary> doubling = double_nodes(result->mesh, upper, lower);
  if (!doubling) return doubling.error();
  result->doubling = std::move(*doubling);

  DROGUE_TRY(check_volume(result->mesh));
  const std::vector<NamedSurface>& boundaries = result->mesh.boundaries;
  DROGUE_TRY(check_two_sided(boundaries[boundaries.size() - 2].triangles, boundaries.back().triangles));
  return result;
}

} // namespace drogue::meshing
