// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/box_mesher.hpp"

#include <algorithm>

#include <gmsh.h>

#include "common/mesh/gmsh_session.hpp"

namespace drogue::meshing {
namespace {

using Index = std::size_t;

constexpr int membrane_tag = 1000; ///< of the embedded discrete surface; its free edges follow

struct BoxEntities {
  int inflow = 0;
  int outflow = 0;
  std::array<int, 4> sides{};
  int volume = 0;
};

BoxEntities add_box(const Box& box) {
  namespace geo = gmsh::model::geo;
  BoxEntities entities;
  std::array<std::array<int, 4>, 2> corner{}, edge{};
  std::array<int, 4> upright{};
  for (Index level = 0; level < 2; ++level) {
    const double z = level == 0 ? box.low.z() : box.high.z();
    corner[level] = {geo::addPoint(box.low.x(), box.low.y(), z), geo::addPoint(box.high.x(), box.low.y(), z),
                     geo::addPoint(box.high.x(), box.high.y(), z),
                     geo::addPoint(box.low.x(), box.high.y(), z)};
    for (Index i = 0; i < 4; ++i) edge[level][i] = geo::addLine(corner[level][i], corner[level][(i + 1) % 4]);
  }
  for (Index i = 0; i < 4; ++i) upright[i] = geo::addLine(corner[0][i], corner[1][i]);
  const auto plane = [](const std::vector<int>& loop) {
    return geo::addPlaneSurface({geo::addCurveLoop(loop)});
  };
  entities.inflow = plane({edge[0].begin(), edge[0].end()});
  entities.outflow = plane({edge[1].begin(), edge[1].end()});
  for (Index i = 0; i < 4; ++i)
    entities.sides[i] = plane({edge[0][i], upright[(i + 1) % 4], -edge[1][i], -upright[i]});
  std::vector<int> shell{entities.inflow, entities.outflow};
  shell.insert(shell.end(), entities.sides.begin(), entities.sides.end());
  entities.volume = geo::addVolume({geo::addSurfaceLoop(shell)});
  geo::synchronize();
  return entities;
}

TetMesh collect(const BoxEntities& entities) {
  gmsh_volume::Nodes nodes = gmsh_volume::nodes();
  TetMesh m;
  m.points = std::move(nodes.points);
  m.tets = gmsh_volume::tets(nodes.index, entities.volume);
  m.interior = gmsh_volume::triangles(nodes.index, membrane_tag);
  m.boundaries = {{"inflow", gmsh_volume::triangles(nodes.index, entities.inflow)},
                  {"outflow", gmsh_volume::triangles(nodes.index, entities.outflow)},
                  {"side", {}}};
  for (const int side : entities.sides) {
    const std::vector<Triangle> triangles = gmsh_volume::triangles(nodes.index, side);
    m.boundaries.back().triangles.insert(m.boundaries.back().triangles.end(), triangles.begin(),
                                         triangles.end());
  }
  orient(m);
  return m;
}

bool inside(const Box& box, const std::vector<Point>& points) {
  return std::all_of(points.begin(), points.end(), [&](const Point& x) {
    return (x.array() > box.low.array()).all() && (x.array() < box.high.array()).all();
  });
}

bool kept(const TetMesh& m, const std::vector<Point>& points, const std::vector<Triangle>& surface) {
  return m.points.size() > points.size() && std::equal(points.begin(), points.end(), m.points.begin()) &&
         m.interior == surface;
}

Result<TetMesh> mesh_with_gmsh(const Box& box, const std::vector<Point>& points,
                               const std::vector<Triangle>& surface, const SizeFunction& size) {
  gmsh_volume::add_surface(membrane_tag, points, surface);
  const BoxEntities entities = add_box(box);
  gmsh::model::mesh::embed(2, {membrane_tag}, 3, entities.volume);
  gmsh_volume::generate(size);
  TetMesh m = collect(entities);
  if (m.tets.empty())
    return numerical_error("Gmsh made no tetrahedra ({})", mesh::gmsh_reason("no reason given"));
  if (!kept(m, points, surface))
    return numerical_error("Gmsh changed the embedded surface ({})", mesh::gmsh_reason("no reason given"));
  return m;
}

} // namespace

Result<TetMesh> mesh_box(const Box& box, const std::vector<Point>& points,
                         const std::vector<Triangle>& surface, const SizeFunction& size) {
  if (!inside(box, points)) return numerical_error("the embedded surface is not inside the box");
  return gmsh_volume::with_gmsh([&] { return mesh_with_gmsh(box, points, surface, size); });
}

} // namespace drogue::meshing
