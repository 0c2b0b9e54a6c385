// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/shell_mesher.hpp"

#include <algorithm>

#include <gmsh.h>

#include "common/mesh/gmsh_session.hpp"

namespace drogue::meshing {
namespace {

using Index = std::size_t;

constexpr int first_tag = 1000;
constexpr int tags_between = 1000; ///< of two surfaces: for the curves of the free edges

std::vector<Triangle> joined(const std::vector<std::vector<Triangle>>& parts) {
  std::vector<Triangle> all;
  for (const std::vector<Triangle>& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

bool kept(const TetMesh& m, const MergedSurface& surface) {
  return m.points.size() >= surface.points.size() &&
         std::equal(surface.points.begin(), surface.points.end(), m.points.begin());
}

Result<TetMesh> fill(const MergedSurface& surface, const SizeFunction& size) {
  namespace geo = gmsh::model::geo;
  int tag = first_tag;
  std::vector<int> loops, membranes;
  std::set<std::int32_t> on_shells;
  for (const std::vector<Triangle>& shell : surface.shells) {
    gmsh_volume::add_surface(tag, surface.points, shell);
    loops.push_back(geo::addSurfaceLoop({tag}));
    for (const Triangle& t : shell) on_shells.insert(t.begin(), t.end());
    tag += tags_between;
  }
  for (const std::vector<Triangle>& sheet : surface.sheets) {
    gmsh_volume::add_surface(tag, surface.points, sheet, &on_shells);
    membranes.push_back(tag);
    tag += tags_between;
  }
  const int volume = geo::addVolume(loops);
  geo::synchronize();
  if (!membranes.empty()) gmsh::model::mesh::embed(2, membranes, 3, volume);
  gmsh_volume::generate(size);
  gmsh_volume::Nodes nodes = gmsh_volume::nodes();
  TetMesh m;
  m.points = std::move(nodes.points);
  m.tets = gmsh_volume::tets(nodes.index, volume);
  m.interior = joined(surface.sheets);
  m.boundaries = {{"shell", joined(surface.shells)}};
  orient(m);
  if (m.tets.empty())
    return numerical_error("Gmsh made no tetrahedra ({})", mesh::gmsh_reason("no reason given"));
  if (!kept(m, surface))
    return numerical_error("Gmsh changed the surfaces ({})", mesh::gmsh_reason("no reason given"));
  return m;
}

} // namespace

Result<TetMesh> mesh_shells(const MergedSurface& surface, const SizeFunction& size) {
  return gmsh_volume::with_gmsh([&] { return fill(surface, size); });
}

} // namespace drogue::meshing
