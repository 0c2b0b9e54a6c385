// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/structure_mesh.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace drogue::parachute {
namespace {

using mesh::ElementBlock;
using mesh::ElementKind;
using mesh::Mesh;
using Position = std::array<double, 3>;

std::int32_t add_node(Mesh& m, const Position& x) {
  m.points.insert(m.points.end(), x.begin(), x.end());
  return m.node_count() - 1;
}

Position position(const Mesh& m, std::int32_t node) {
  const std::size_t i = 3 * static_cast<std::size_t>(node);
  return {m.points[i], m.points[i + 1], m.points[i + 2]};
}

/// A straight line of `elements` cables from one node to another, with new nodes between them.
void add_line(Mesh& m, ElementBlock& cables, std::int32_t from, std::int32_t to, int elements) {
  const Position a = position(m, from), b = position(m, to);
  std::int32_t previous = from;
  for (int k = 1; k <= elements; ++k) {
    const double t = static_cast<double>(k) / elements;
    const std::int32_t next =
        k == elements
            ? to
            : add_node(m, {std::lerp(a[0], b[0], t), std::lerp(a[1], b[1], t), std::lerp(a[2], b[2], t)});
    cables.nodes.insert(cables.nodes.end(), {previous, next});
    previous = next;
  }
}

ElementBlock radial_cables(const Cloth& cloth) {
  ElementBlock radials{"radials", ElementKind::line2, {}};
  for (const auto& radial : cloth.radials)
    for (std::size_t i = 0; i + 1 < radial.size(); ++i)
      radials.nodes.insert(radials.nodes.end(), {radial[i], radial[i + 1]});
  return radials;
}

/// The confluence points, the one at y > 0 first.
std::vector<std::int32_t> add_confluence_points(Mesh& m, const Canopy& canopy, const Rigging& rigging) {
  const double r = canopy.flat_radius(canopy.s_skirt());
  const double z = -std::sqrt(rigging.line_length * rigging.line_length - r * r);
  if (rigging.confluence_distance == 0) return {add_node(m, {0, 0, z})};
  const double y = 0.5 * rigging.confluence_distance;
  const std::int32_t first = add_node(m, {0, y, z});
  return {first, add_node(m, {0, -y, z})};
}

void add_material_field(Mesh& m, const Cloth& cloth) {
  mesh::NodeField material{3, {}};
  for (const ClothNode& node : cloth.nodes)
    for (const double x : material_position(node)) material.values.push_back(x);
  material.values.resize(m.points.size(), std::numeric_limits<double>::quiet_NaN());
  m.node_fields.emplace("material", std::move(material));
}

} // namespace

Mesh structure_mesh(const Canopy& canopy, const Rigging& rigging, const StructureSettings& settings) {
  Mesh m;
  const Cloth cloth =
      settings.quadratic ? quadratic_cloth(canopy, settings.rows) : triangulate_cloth(canopy, settings.rows);
  for (const ClothNode& node : cloth.nodes) add_node(m, flat_position(canopy, node));
  const std::vector<std::int32_t> confluence = add_confluence_points(m, canopy, rigging);
  const std::int32_t apex = add_node(m, {0, 0, 0});

  ElementBlock vent_lines{"vent_lines", ElementKind::line2, {}};
  ElementBlock suspension_lines{"suspension_lines", ElementKind::line2, {}};
  ElementBlock skirt_edge{"skirt_edge", ElementKind::point1, {}};
  for (std::size_t g = 0; g < cloth.radials.size(); ++g) {
    const auto& radial = cloth.radials[g];
    const std::size_t group = g * confluence.size() / cloth.radials.size();
    add_line(m, vent_lines, radial.front(), apex, rigging.vent_elements);
    add_line(m, suspension_lines, radial.back(), confluence[group], rigging.line_elements);
    skirt_edge.nodes.push_back(radial.back());
  }
  add_material_field(m, cloth);

  m.blocks = {{"canopy", cloth.kind, cloth.elements},
              radial_cables(cloth),
              std::move(vent_lines),
              std::move(suspension_lines),
              {"confluence", ElementKind::point1, confluence},
              {"apex", ElementKind::point1, {apex}},
              std::move(skirt_edge)};
  return m;
}

} // namespace drogue::parachute
