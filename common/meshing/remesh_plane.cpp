// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/remesh_plane.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "common/meshing/plane_mesher.hpp"
#include "common/meshing/refill.hpp"

namespace drogue::meshing {
namespace {

using Index = std::size_t;
using Plane = refill::Simplices<2>;

/// Relative difference of the areas before and after that is rounding.
constexpr double area_rounding = 1e-9;

Result<std::string> cell_group(const mesh::Mesh& m) {
  std::string group;
  for (const mesh::ElementBlock& block : m.blocks) {
    if (block.kind == mesh::ElementKind::line2) continue;
    if (block.kind != mesh::ElementKind::tri3)
      return config_error(
          "group \"{}\" has elements of the kind {}: a plane mesh can be meshed anew if it has 3-node "
          "triangles with 2-node lines on the boundary",
          block.group, mesh::name(block.kind));
    if (!group.empty() && group != block.group)
      return config_error("the triangles are in the groups \"{}\" and \"{}\": only those of one group can be "
                          "meshed anew",
                          group, block.group);
    group = block.group;
  }
  if (group.empty()) return config_error("the mesh has neither tetrahedra nor triangles");
  return group;
}

double twice_area(const std::vector<Point>& x, const Triangle& t) {
  const Point& o = x[static_cast<Index>(t[0])];
  const Point a = x[static_cast<Index>(t[1])] - o, b = x[static_cast<Index>(t[2])] - o;
  return a.x() * b.y() - a.y() * b.x();
}

/// The triangles, anticlockwise.
Plane plane_of(const mesh::Mesh& m) {
  Plane plane;
  for (Index i = 0; i < m.points.size(); i += 3)
    plane.points.emplace_back(m.points[i], m.points[i + 1], m.points[i + 2]);
  for (const mesh::ElementBlock& block : m.blocks) {
    if (block.kind != mesh::ElementKind::tri3) continue;
    for (std::int32_t e = 0; e < block.count(); ++e) {
      Triangle& t = plane.cells.emplace_back();
      std::copy_n(block.element(e).begin(), 3, t.begin());
      if (twice_area(plane.points, t) < 0) std::swap(t[1], t[2]);
    }
  }
  return plane;
}

/// Area within a loop, negative when it runs clockwise.
double area_within(const std::vector<Point>& x, const std::vector<Edge>& loop) {
  double sum = 0;
  for (const Edge& e : loop) {
    const Point &a = x[static_cast<Index>(e[0])], &b = x[static_cast<Index>(e[1])];
    sum += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return sum;
}

/// Edges of one triangle only, one after the other, the triangles on the left; the outermost loop first.
/// Two nodes at one place, as the two sides of a cut have them, are a fault of the outline to Gmsh.
Result<std::vector<std::vector<Edge>>> outlines(const std::vector<Point>& x,
                                                const std::vector<Triangle>& cells) {
  std::set<Edge> edges;
  for (const Triangle& t : cells)
    for (Index a = 0; a < 3; ++a) {
      const Edge edge{t[a], t[(a + 1) % 3]};
      if (edges.erase({edge[1], edge[0]}) == 0) edges.insert(edge);
    }
  std::map<std::int32_t, std::int32_t> next;
  std::set<std::pair<double, double>> places;
  for (const Edge& edge : edges) {
    const Point& p = x[static_cast<Index>(edge[0])];
    if (!next.insert({edge[0], edge[1]}).second || !places.insert({p.x(), p.y()}).second)
      return config_error(
          "the boundary touches itself at ({:.6g}, {:.6g}), as the two sides of a cut do: such "
          "a plane mesh cannot be meshed anew",
          p.x(), p.y());
  }
  std::vector<std::vector<Edge>> loops;
  while (!next.empty()) {
    std::vector<Edge>& loop = loops.emplace_back();
    for (auto at = next.begin(); at != next.end(); at = next.find(loop.back()[1])) {
      loop.push_back({at->first, at->second});
      next.erase(at);
    }
  }
  std::iter_swap(loops.begin(),
                 std::max_element(loops.begin(), loops.end(), [&](const auto& a, const auto& b) {
                   return area_within(x, a) < area_within(x, b);
                 }));
  return loops;
}

Result<refill::Filling<2>> fill(const Plane& old, const std::vector<Triangle>& cells, std::int32_t first_new,
                                const SizeFunction& size) {
  const auto loops = outlines(old.points, cells);
  if (!loops) return loops.error();
  auto filled = mesh_region(old.points, *loops, size);
  if (!filled) return filled.error();
  std::vector<std::int32_t> number; // as mesh_region counts
  for (const std::vector<Edge>& loop : *loops)
    for (const Edge& edge : loop) number.push_back(edge[0]);
  refill::Filling<2> result;
  const auto kept = static_cast<std::ptrdiff_t>(number.size());
  result.points.assign(filled->points.begin() + kept, filled->points.end());
  for (Index i = 0; i < result.points.size(); ++i) number.push_back(first_new + static_cast<std::int32_t>(i));
  for (Triangle t : filled->interior) {
    for (std::int32_t& node : t) node = number[static_cast<Index>(node)];
    result.cells.push_back(t);
  }
  return result;
}

template <class Renumbered>
std::set<Edge> outer_edges(const std::vector<Triangle>& cells, Renumbered&& renumbered) {
  std::set<Edge> edges;
  for_equal_keys(refill::sorted_facets<2>(cells), [&](auto first, auto last) {
    if (last - first == 1) edges.insert(sorted(Edge{renumbered(first->key[0]), renumbered(first->key[1])}));
  });
  return edges;
}

/// The triangles must lie in a plane z = const, and the lines must be their outer edges.
Result<void> check_input(const Plane& plane, const mesh::Mesh& m) {
  for (const Triangle& t : plane.cells)
    for (const std::int32_t node : t)
      if (const Point& x = plane.points[static_cast<Index>(node)];
          x.z() != plane.points[static_cast<Index>(plane.cells[0][0])].z())
        return config_error("({:.6g}, {:.6g}, {:.6g}) lies in another plane z = const than other triangles",
                            x.x(), x.y(), x.z());
  std::set<Edge> lines;
  for (const mesh::ElementBlock& block : m.blocks)
    if (block.kind == mesh::ElementKind::line2)
      for (std::int32_t e = 0; e < block.count(); ++e)
        lines.insert(sorted(Edge{block.element(e)[0], block.element(e)[1]}));
  if (lines != outer_edges(plane.cells, [](std::int32_t node) { return node; }))
    return config_error("the lines are not all the outer edges of the triangles, or more than these");
  return {};
}

/// Turns clockwise triangles; then all must have an area, together that of the old ones, and their outer
/// edges must be those of the old ones.
Result<void> check(Plane& m, const std::vector<std::int32_t>& number, const Plane& old) {
  double area = 0, area_before = 0;
  for (Triangle& t : m.cells) {
    if (twice_area(m.points, t) < 0) std::swap(t[1], t[2]);
    if (!(twice_area(m.points, t) > 0)) {
      const Point& x = m.points[static_cast<Index>(t[0])];
      return numerical_error("the new mesh has a triangle without an area at ({:.6g}, {:.6g})", x.x(), x.y());
    }
    area += twice_area(m.points, t) / 2;
  }
  for (const Triangle& t : old.cells) area_before += twice_area(old.points, t) / 2;
  if (std::abs(area - area_before) > area_rounding * area_before)
    return numerical_error("the new mesh fills an area of {:.12g} in place of {:.12g}", area, area_before);
  const auto now = outer_edges(m.cells, [](std::int32_t node) { return node; });
  const auto before =
      outer_edges(old.cells, [&](std::int32_t node) { return number[static_cast<Index>(node)]; });
  if (now != before) return numerical_error("the new mesh does not keep the edges of the boundary");
  return {};
}

/// The lines of the old mesh, then the new triangles.
mesh::Mesh to_mesh(const refill::Refilled<2>& made, const mesh::Mesh& old, const std::string& group) {
  mesh::Mesh m;
  for (const Point& x : made.mesh.points) m.points.insert(m.points.end(), x.begin(), x.end());
  for (const mesh::ElementBlock& block : old.blocks) {
    if (block.kind != mesh::ElementKind::line2) continue;
    mesh::ElementBlock& lines = m.blocks.emplace_back(block);
    for (std::int32_t& node : lines.nodes) node = made.number[static_cast<Index>(node)];
  }
  mesh::ElementBlock& cells = m.blocks.emplace_back(mesh::ElementBlock{group, mesh::ElementKind::tri3, {}});
  for (const Triangle& t : made.mesh.cells) cells.nodes.insert(cells.nodes.end(), t.begin(), t.end());
  return m;
}

} // namespace

Result<mesh::Mesh> remesh_plane(const mesh::Mesh& old_mesh) {
  const auto group = cell_group(old_mesh);
  if (!group) return group.error();
  const Plane old = plane_of(old_mesh);
  DROGUE_TRY(check_input(old, old_mesh));
  const SimplexLocator<2> locator(old.points, old.cells);
  const mesh::NodeField size = refill::size_field(old_mesh);
  refill::Sizes<2> sizes(old.cells, locator, size.values);
  const auto size_at = [&](const Point& x) { return sizes(x); };
  const auto made = refill::refilled_where_worn<2>(
      old_mesh, old, [&](const std::vector<char>& in) -> Result<refill::Refilled<2>> {
        auto r = refill::replaced<2>(old, in, [&](const std::vector<Triangle>& cells, std::int32_t first) {
          return fill(old, cells, first, size_at);
        });
        if (r) DROGUE_TRY(check(r->mesh, r->number, old));
        return r;
      });
  if (!made) return made.error();
  mesh::Mesh result = to_mesh(*made, old_mesh, *group);
  refill::carry_fields<2>(old_mesh, size, old, locator, *made, result);
  return result;
}

} // namespace drogue::meshing
