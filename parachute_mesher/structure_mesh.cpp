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

/// Where the lines end: one point, two with the one at y > 0 first, or with risers four in the order of
/// theta.
std::vector<std::int32_t> add_confluence_points(Mesh& m, const Canopy& canopy, const Rigging& rigging) {
  const double r = canopy.radius(canopy.s_skirt());
  const double z =
      canopy.height(canopy.s_skirt()) - std::sqrt(rigging.line_length * rigging.line_length - r * r);
  const double y = 0.5 * rigging.confluence_distance;
  std::vector<Position> points{{0, 0, z}};
  if (rigging.risers) {
    const double x = 0.5 * rigging.risers->confluence_depth;
    points = {{x, y, z}, {-x, y, z}, {-x, -y, z}, {x, -y, z}};
  } else if (y > 0) {
    points = {{0, y, z}, {0, -y, z}};
  }
  std::vector<std::int32_t> nodes;
  for (const Position& point : points) nodes.push_back(add_node(m, point));
  return nodes;
}

/// The confluence point of each of `lines` lines, which follow one another by theta from the x axis on.
std::vector<std::size_t> confluence_of_lines(std::size_t lines, std::size_t points) {
  const std::size_t left = points == 1 ? lines : (lines + 1) / 2, right = lines - left; // y > 0 and y < 0
  std::vector<std::size_t> shares{left, right};
  if (points == 4) shares = {left / 2, left - left / 2, right - right / 2, right / 2};
  std::vector<std::size_t> result;
  for (std::size_t point = 0; point < shares.size(); ++point)
    result.insert(result.end(), shares[point], point);
  return result;
}

/// Risers from the confluence points to the corners of the payload: FL up, RL down, RR up, FR down.
void add_payload(Mesh& m, const Risers& risers, const std::vector<std::int32_t>& confluence) {
  ElementBlock cables{"risers", ElementKind::line2, {}}, trusses{"payload_trusses", ElementKind::line2, {}};
  ElementBlock corners{"payload", ElementKind::point1, {}};
  for (std::size_t k = 0; k < confluence.size(); ++k) {
    const Position top = position(m, confluence[k]);
    const double half = 0.5 * risers.payload_width, up = k % 2 == 0 ? 0.5 : -0.5;
    corners.nodes.push_back(add_node(m, {std::copysign(half, top[0]), std::copysign(half, top[1]),
                                         top[2] - risers.length + up * risers.payload_height}));
  }
  for (std::size_t k = 0; k < confluence.size(); ++k)
    add_line(m, cables, confluence[k], corners.nodes[k], risers.elements);
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = a + 1; b < 4; ++b)
      trusses.nodes.insert(trusses.nodes.end(), {corners.nodes[a], corners.nodes[b]});
  for (ElementBlock* block : {&cables, &trusses, &corners}) m.blocks.push_back(std::move(*block));
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
  const Cloth cloth = mesh_cloth(canopy, settings.rows, settings.element);
  for (const ClothNode& node : cloth.nodes) add_node(m, constructed_position(canopy, node));
  const std::vector<std::int32_t> confluence = add_confluence_points(m, canopy, rigging);
  ElementBlock vent_lines{"vent_lines", ElementKind::line2, {}};
  ElementBlock suspension_lines{"suspension_lines", ElementKind::line2, {}};
  ElementBlock inner_lines{"inner_lines", ElementKind::line2, {}};
  ElementBlock apex{"apex", ElementKind::point1, {}};
  if (rigging.vent_elements > 0 && !cloth.vent.empty()) apex.nodes.push_back(add_node(m, {0, 0, 0}));
  const std::vector<std::size_t> confluence_of = confluence_of_lines(cloth.skirt.size(), confluence.size());
  for (std::size_t line = 0; line < cloth.skirt.size(); ++line) {
    const std::int32_t end = confluence[confluence_of[line]];
    if (!apex.nodes.empty()) add_line(m, vent_lines, cloth.vent[line], apex.nodes[0], rigging.vent_elements);
    add_line(m, suspension_lines, cloth.skirt[line], end, rigging.line_elements);
    if (rigging.inner_line_elements > 0)
      add_line(m, inner_lines, cloth.vent[line], end, rigging.inner_line_elements);
  }

  m.blocks = {{"canopy", cloth.kind, cloth.elements},
              radial_cables(cloth),
              std::move(vent_lines),
              std::move(suspension_lines),
              std::move(inner_lines),
              {"confluence", ElementKind::point1, confluence},
              std::move(apex),
              {"skirt_edge", ElementKind::point1, cloth.skirt}};
  if (rigging.risers) add_payload(m, *rigging.risers, confluence);
  std::erase_if(m.blocks, [](const ElementBlock& block) { return block.nodes.empty(); });
  add_material_field(m, cloth);
  return m;
}

} // namespace drogue::parachute
