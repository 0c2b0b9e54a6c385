// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/verification/plane_mesh.hpp"

#include <gmsh.h>

#include <map>

namespace drogue::fluid::test {
namespace {

/// Gmsh fills only arrays that come empty.
std::vector<std::size_t> nodes_of_elements(int type, int entity) {
  std::vector<std::size_t> elements, nodes;
  gmsh::model::mesh::getElementsByType(type, elements, nodes, entity);
  return nodes;
}

/// The nodes and the elements of the groups of Gmsh's current model.
mesh::Mesh collect(const std::vector<std::pair<std::string, std::vector<int>>>& curves, int surface) {
  mesh::Mesh m;
  std::vector<std::size_t> tags;
  std::vector<double> x, parametric;
  gmsh::model::mesh::getNodes(tags, x, parametric);
  std::map<std::size_t, std::size_t> place; // in the order of the tags
  for (std::size_t i = 0; i < tags.size(); ++i) place[tags[i]] = i;
  std::map<std::size_t, std::int32_t> number;
  std::map<std::size_t, bool> used;
  for (const std::size_t tag : nodes_of_elements(2, surface)) used[tag] = true;
  for (const auto& [tag, is_used] : used) {
    number[tag] = static_cast<std::int32_t>(m.points.size() / 3);
    const auto from = x.begin() + static_cast<std::ptrdiff_t>(3 * place[tag]);
    m.points.insert(m.points.end(), from, from + 3);
  }
  const auto add = [&](const std::string& group, mesh::ElementKind kind, const std::vector<int>& entities) {
    mesh::ElementBlock block{group, kind, {}};
    for (const int entity : entities)
      for (const std::size_t tag : nodes_of_elements(kind == mesh::ElementKind::tri3 ? 2 : 1, entity))
        block.nodes.push_back(number.at(tag));
    m.blocks.push_back(std::move(block));
  };
  add("fluid", mesh::ElementKind::tri3, {surface});
  for (const auto& [group, entities] : curves) add(group, mesh::ElementKind::line2, entities);
  return m;
}

} // namespace

mesh::Mesh triangulated(int surface, const std::vector<std::pair<std::string, std::vector<int>>>& curves,
                        const PlaneSize& size) {
  gmsh::model::mesh::setSizeCallback([&size](int, int, double x, double y, double) { return size(x, y); });
  gmsh::option::setNumber("General.NumThreads", 1);
  gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 0);
  gmsh::option::setNumber("Mesh.MeshSizeFromPoints", 0);
  gmsh::option::setNumber("Mesh.Algorithm", 6);
  gmsh::option::setNumber("Mesh.Smoothing", 5);
  gmsh::model::mesh::generate(2);
  gmsh::model::mesh::removeSizeCallback();
  return collect(curves, surface);
}

} // namespace drogue::fluid::test
