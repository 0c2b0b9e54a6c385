// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/plane_mesher.hpp"

#include <algorithm>

#include <gmsh.h>

#include "common/mesh/gmsh_session.hpp"

namespace drogue::meshing {
namespace {

using Index = std::size_t;
constexpr int surface_tag = 1;

/// Gives Gmsh the points (tags from 1 on) and lines of closed loops, and returns the tags of these.
std::vector<int> add_loops(const std::vector<Point>& points, const std::vector<std::vector<Edge>>& loops,
                           std::vector<Point>& used) {
  namespace geo = gmsh::model::geo;
  std::vector<int> tags;
  for (const std::vector<Edge>& loop : loops) {
    const int first = static_cast<int>(used.size()) + 1, count = static_cast<int>(loop.size());
    for (const Edge& edge : loop) {
      const Point& x = used.emplace_back(points[static_cast<Index>(edge[0])]);
      geo::addPoint(x.x(), x.y(), x.z(), 0, static_cast<int>(used.size()));
    }
    std::vector<int> lines;
    for (int i = 0; i < count; ++i) {
      lines.push_back(geo::addLine(first + i, first + (i + 1) % count));
      geo::mesh::setTransfiniteCurve(lines.back(), 2);
    }
    tags.push_back(geo::addCurveLoop(lines));
  }
  return tags;
}

Result<TetMesh> fill(const std::vector<Point>& points, const std::vector<std::vector<Edge>>& loops,
                     const SizeFunction& size) {
  TetMesh m;
  std::vector<Point> used;
  gmsh::model::geo::addPlaneSurface(add_loops(points, loops, used), surface_tag);
  gmsh::model::geo::synchronize();
  gmsh_volume::generate(size, 2);
  gmsh_volume::Nodes nodes = gmsh_volume::nodes();
  m.points = std::move(nodes.points);
  m.interior = gmsh_volume::triangles(nodes.index, surface_tag);
  if (m.interior.empty())
    return numerical_error("Gmsh made no triangles ({})", mesh::gmsh_reason("no reason given"));
  if (m.points.size() < used.size() || !std::equal(used.begin(), used.end(), m.points.begin()))
    return numerical_error("Gmsh changed the boundary ({})", mesh::gmsh_reason("no reason given"));
  for (Index i = used.size(); i < m.points.size(); ++i) m.points[i].z() = points[0].z();
  return m;
}

} // namespace

Result<TetMesh> mesh_region(const std::vector<Point>& points, const std::vector<std::vector<Edge>>& loops,
                            const SizeFunction& size) {
  return gmsh_volume::with_gmsh([&] { return fill(points, loops, size); });
}

} // namespace drogue::meshing
