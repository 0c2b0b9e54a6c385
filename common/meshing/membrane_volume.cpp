// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/membrane_volume.hpp"

#include <utility>

#include "common/meshing/checks.hpp"
#include "common/meshing/membrane_checks.hpp"

namespace drogue::meshing {

Result<MembraneVolume> mesh_membrane_volume(const Box& box, const std::vector<Point>& points,
                                            const std::vector<Triangle>& membrane, const SizeRule& sizes,
                                            const std::string& upper, const std::string& lower) {
  DROGUE_TRY(check_membrane(points, membrane));
  const SizeField size(sizes, points, membrane);
  Result<TetMesh> meshed = mesh_box(box, points, membrane, [&](const Point& x) { return size(x); });
  if (!meshed) return meshed.error();

  MembraneVolume result{.mesh = std::move(*meshed), .split = {}, .smoothing_moves = 0, .doubling = {}};
  result.split = split_bridges(result.mesh);
  result.smoothing_moves = smooth_bad_tets(result.mesh, 0.25, 8);
  result.smoothing_moves += smooth_bad_tets(result.mesh, 0.35, 4);
  Result<DoublingSummary> doubling = double_nodes(result.mesh, upper, lower);
  if (!doubling) return doubling.error();
  result.doubling = std::move(*doubling);

  DROGUE_TRY(check_volume(result.mesh));
  const std::vector<NamedSurface>& boundaries = result.mesh.boundaries;
  DROGUE_TRY(check_two_sided(boundaries[boundaries.size() - 2].triangles, boundaries.back().triangles));
  return result;
}

} // namespace drogue::meshing
