// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmsh.h>

#include "common/mesh/gmsh_session.hpp"
#include "common/mesh/msh_content.hpp"

namespace drogue::mesh {
namespace {

std::string gmsh_name(int type) {
  std::string name;
  int dimension = 0, order = 0, nodes = 0, primary_nodes = 0;
  std::vector<double> parametric;
  gmsh::model::mesh::getElementProperties(type, name, dimension, order, nodes, parametric, primary_nodes);
  return name;
}

Result<MshContent> content_of_model(const std::string& file) {
  MshContent content;
  std::vector<std::size_t> tags;
  std::vector<double> parametric;
  gmsh::model::mesh::getNodes(tags, content.points, parametric);
  content.node_tags.assign(tags.begin(), tags.end());
  std::vector<MshContent::DimTag> entities;
  gmsh::model::getEntities(entities);
  for (const auto& [dimension, entity] : entities) {
    std::vector<int> types, groups;
    std::vector<std::vector<std::size_t>> element_tags, node_tags;
    gmsh::model::mesh::getElements(types, element_tags, node_tags, dimension, entity);
    gmsh::model::getPhysicalGroupsForEntity(dimension, entity, groups);
    for (const int group : groups)
      gmsh::model::getPhysicalName(dimension, group, content.group_names[{dimension, group}]);
    for (std::size_t i = 0; i < types.size(); ++i) {
      const auto kind = kind_of(types[i]);
      if (!kind)
        return config_error("{}: elements of the unknown kind \"{}\"; known are {}", file,
                            gmsh_name(types[i]), known_kinds);
      content.elements.push_back({*kind,
                                  entity,
                                  groups,
                                  {element_tags[i].begin(), element_tags[i].end()},
                                  {node_tags[i].begin(), node_tags[i].end()}});
    }
  }
  return content;
}

} // namespace

Result<MshContent> read_by_gmsh(const std::string& file) {
  const GmshSession session;
  try {
    gmsh::merge(file);
    return content_of_model(file);
  } catch (...) {
    return config_error("{}: Gmsh cannot read the file: {}", file, gmsh_reason("no reason given"));
  }
}

} // namespace drogue::mesh
