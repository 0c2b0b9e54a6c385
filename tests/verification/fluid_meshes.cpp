// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/verification/fluid_meshes.hpp"

#include <gmsh.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "common/mesh/gmsh_session.hpp"
#include "tests/verification/plane_mesh.hpp"

namespace drogue::fluid::test {
namespace {

namespace geo = gmsh::model::geo;

int at(int i, int j, int columns) {
  return j * columns + i;
}

/// Positions from 0 to `length` whose steps grow by a constant factor from `first`.
std::vector<double> growing(double length, double first, int steps) {
  double low = 1;
  double high = 2;
  const auto sum = [&](double q) {
    return q == 1 ? first * steps : first * (std::pow(q, steps) - 1) / (q - 1);
  };
  for (int k = 0; k < 100; ++k) (sum(0.5 * (low + high)) < length ? low : high) = 0.5 * (low + high);
  std::vector<double> positions{0};
  for (int k = 1; k <= steps; ++k)
    positions.push_back(length * (std::pow(low, k) - 1) / (std::pow(low, steps) - 1));
  return positions;
}

/// The number of steps for which they grow to about `last`.
int step_count(double length, double first, double last) {
  const double q = (length - first) / (length - last); // of a geometric series
  return std::max(2, static_cast<int>(std::lround(std::log(last / first) / std::log(q))) + 1);
}

/// Curves of the obstacle, anticlockwise: the circle in arcs, with the plate's three sides in it.
std::vector<int> add_obstacle(const Channel& c) {
  const auto point = [&](double x, double y) { return geo::addPoint(c.centre[0] + x, c.centre[1] + y, 0); };
  const int centre = point(0, 0);
  const int top = point(0, c.radius);
  const int left = point(-c.radius, 0);
  const int bottom = point(0, -c.radius);
  std::vector<int> curves{geo::addCircleArc(top, centre, left), geo::addCircleArc(left, centre, bottom)};
  if (c.plate_thickness == 0) {
    const int right = point(c.radius, 0);
    curves.push_back(geo::addCircleArc(bottom, centre, right));
    curves.push_back(geo::addCircleArc(right, centre, top));
    return curves;
  }
  const double half = 0.5 * c.plate_thickness;
  const double root = std::sqrt(c.radius * c.radius - half * half);
  const double end = c.plate_end - c.centre[0];
  const int corner[4] = {point(root, -half), point(end, -half), point(end, half), point(root, half)};
  curves.push_back(geo::addCircleArc(bottom, centre, corner[0]));
  for (int k = 0; k < 3; ++k) curves.push_back(geo::addLine(corner[k], corner[k + 1]));
  curves.push_back(geo::addCircleArc(corner[3], centre, top));
  return curves;
}

/// Boundary edges or triangles of a block, in groups by a name that depends on the nodes' positions.
void add_face(mesh::Mesh& m, const std::string& group, std::initializer_list<int> nodes) {
  auto found =
      std::find_if(m.blocks.begin(), m.blocks.end(), [&](const auto& b) { return b.group == group; });
  if (found == m.blocks.end())
    found = m.blocks.insert(
        m.blocks.end(), {group, nodes.size() == 2 ? mesh::ElementKind::line2 : mesh::ElementKind::tri3, {}});
  found->nodes.insert(found->nodes.end(), nodes);
}

/// The tetrahedra between a triangle and its copy in the next layer; neighbours cut their common side alike,
/// because the diagonal starts at the smaller node. Positive volumes above a counter-clockwise triangle.
void add_prism(mesh::ElementBlock& block, std::array<int, 3> low, int layer) {
  const bool turned = (low[0] < low[1]) + (low[1] < low[2]) + (low[2] < low[0]) == 1;
  std::sort(low.begin(), low.end());
  const auto [a, b, c] = low;
  const std::array<std::array<int, 4>, 3> cells = {
      {{a, b, c, c + layer}, {a, b, c + layer, b + layer}, {a, a + layer, b + layer, c + layer}}};
  for (auto cell : cells) {
    if (turned) std::swap(cell[0], cell[1]);
    block.nodes.insert(block.nodes.end(), cell.begin(), cell.end());
  }
}

/// The two triangles between an edge and its copy, cut as add_prism does.
void add_side(mesh::Mesh& m, const std::string& group, int a, int b, int layer) {
  if (a > b) std::swap(a, b);
  add_face(m, group, {a, b, b + layer});
  add_face(m, group, {a, b + layer, a + layer});
}

} // namespace

double graded(double distance, double fine, double growth, double coarse) {
  return std::min(coarse, fine + growth * std::max(0.0, distance));
}

mesh::Mesh channel_mesh(const Channel& c, const PlaneSize& size) {
  const mesh::GmshSession session;
  const int corner[4] = {geo::addPoint(c.low[0], c.low[1], 0), geo::addPoint(c.high[0], c.low[1], 0),
                         geo::addPoint(c.high[0], c.high[1], 0), geo::addPoint(c.low[0], c.high[1], 0)};
  std::vector<int> outer;
  for (int k = 0; k < 4; ++k) outer.push_back(geo::addLine(corner[k], corner[(k + 1) % 4]));
  const std::vector<int> obstacle = add_obstacle(c);
  const int surface = geo::addPlaneSurface({geo::addCurveLoop(outer), geo::addCurveLoop(obstacle)});
  geo::synchronize();
  std::vector<int> rigid = obstacle, plate;
  if (c.plate_apart) { // the three lines before the last arc
    plate.assign(obstacle.end() - 4, obstacle.end() - 1);
    rigid.erase(rigid.end() - 4, rigid.end() - 1);
  }
  std::vector<std::pair<std::string, std::vector<int>>> groups{{"bottom", {outer[0]}},
                                                               {"outflow", {outer[1]}},
                                                               {"top", {outer[2]}},
                                                               {"inflow", {outer[3]}},
                                                               {"obstacle", rigid}};
  if (!plate.empty()) groups.emplace_back("plate", plate);
  return triangulated(surface, groups, size);
}

PlaneSize flag_sizes(const FlagSizes& sizes) {
  return [wall = sizes.wall, growth = sizes.growth, bulk = sizes.bulk](double x, double y) {
    const double to_circle = std::hypot(x - 0.2, y - 0.2) - 0.05;
    const double to_flag = std::hypot(x - std::clamp(x, 0.2, 0.6), std::max(0.0, std::abs(y - 0.2) - 0.01));
    const double to_end = std::hypot(x - 0.6, std::max(0.0, std::abs(y - 0.2) - 0.01)); // two corners
    const double beside_wake = x > 0.2 ? std::max(std::abs(y - 0.2) - 0.08, 0.1 * (x - 0.8)) : 1.0;
    return std::min({graded(std::min(to_circle, to_flag), wall, growth, bulk),
                     graded(to_end, 0.5 * wall, growth, bulk), graded(beside_wake, 0.5 * bulk, 0.2, bulk)});
  };
}

mesh::Mesh flag_in_channel(const FlagSizes& sizes, bool flag_apart) {
  return channel_mesh({{0, 0}, {2.5, 0.41}, {0.2, 0.2}, 0.05, 0.6, 0.02, flag_apart}, flag_sizes(sizes));
}

mesh::Mesh ring_mesh(double radius, double outer, int around, double first, bool half) {
  const double angle = (half ? 1 : 2) * std::numbers::pi;
  const double last = angle * outer / around;
  const std::vector<double> r = growing(outer - radius, first, step_count(outer - radius, first, last));
  const int columns = half ? around + 1 : around;
  const int rows = static_cast<int>(r.size());
  mesh::Mesh m;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const double phi = angle * i / around;
      const double distance = radius + r[static_cast<std::size_t>(j)];
      m.points.insert(m.points.end(), {distance * std::cos(phi), distance * std::sin(phi), 0.0});
    }
  if (half) // sin(pi) is not zero
    for (int j = 0; j < rows; ++j) m.points[static_cast<std::size_t>(3 * at(around, j, columns) + 1)] = 0;
  m.blocks.push_back({"fluid", mesh::ElementKind::tri3, {}});
  const auto node = [&](int i, int j) { return at(i % columns, j, columns); };
  for (int j = 0; j + 1 < rows; ++j)
    for (int i = 0; i < around; ++i) {
      const int a = node(i, j), b = node(i + 1, j), c = node(i + 1, j + 1), d = node(i, j + 1);
      // mirrored about x = 0 and y = 0
      const bool rising = (i < around / (half ? 2 : 4)) || (!half && i >= around / 2 && i < 3 * around / 4);
      auto& nodes = m.blocks.front().nodes;
      if (rising)
        nodes.insert(nodes.end(), {a, c, b, a, d, c});
      else
        nodes.insert(nodes.end(), {a, d, b, b, d, c});
    }
  for (int i = 0; i < around; ++i) {
    add_face(m, "cylinder", {node(i, 0), node(i + 1, 0)});
    add_face(m, "outer", {node(i, rows - 1), node(i + 1, rows - 1)});
  }
  for (int j = 0; half && j + 1 < rows; ++j)
    for (const int i : {0, around}) add_face(m, "symmetry", {node(i, j), node(i, j + 1)});
  return m;
}

mesh::Mesh extruded(const mesh::Mesh& plane, const std::vector<double>& z) {
  mesh::Mesh m;
  const int layer = plane.node_count();
  for (const double height : z)
    for (std::size_t i = 0; i < plane.points.size(); i += 3)
      m.points.insert(m.points.end(), {plane.points[i], plane.points[i + 1], height});
  const int layers = static_cast<int>(z.size()) - 1;
  for (const auto& block : plane.blocks) {
    if (block.kind == mesh::ElementKind::tri3) m.blocks.push_back({block.group, mesh::ElementKind::tet4, {}});
    for (std::int32_t e = 0; e < block.count(); ++e) {
      const auto nodes = block.element(e);
      for (int k = 0; k < layers; ++k) {
        const int base = k * layer;
        if (block.kind == mesh::ElementKind::line2)
          add_side(m, block.group, base + nodes[0], base + nodes[1], layer);
        else
          add_prism(*std::find_if(m.blocks.begin(), m.blocks.end(),
                                  [&](const auto& b) { return b.group == block.group; }),
                    {base + nodes[0], base + nodes[1], base + nodes[2]}, layer);
      }
      if (block.kind != mesh::ElementKind::tri3) continue;
      add_face(m, "z0", {nodes[0], nodes[1], nodes[2]});
      const int top = layers * layer;
      add_face(m, "z1", {top + nodes[0], top + nodes[1], top + nodes[2]});
    }
  }
  return m;
}

mesh::Mesh sphere_mesh(double radius, double outer, int n, double first) {
  // Two octants (x < 0 and x > 0), each a triangle of n edges a side between (+-1, 0, 0), y and z.
  std::vector<std::array<double, 3>> points;
  std::map<std::array<int, 3>, int> number;
  const auto node = [&](int i, int j, int k) { // i + j + k = n, i along x, negative for x < 0
    const auto [found, added] = number.try_emplace({i, j, k}, static_cast<int>(points.size()));
    if (added) {
      // equal angles along the edges
      const auto weight = [&](int v) { return std::sin(0.5 * std::numbers::pi * v / n); };
      const double x = weight(i), y = weight(j), z = weight(k);
      const double length = std::hypot(x, y, z);
      points.push_back({x / length, y / length, z / length});
    }
    return found->second;
  };
  std::vector<std::array<int, 3>> triangles;
  for (const int side : {-1, 1})
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const int k = n - i - j;
        triangles.push_back(
            {node(side * i, j, k), node(side * (i + 1), j, k - 1), node(side * i, j + 1, k - 1)});
        if (i + j + 1 < n)
          triangles.push_back({node(side * (i + 1), j, k - 1), node(side * (i + 1), j + 1, k - 2),
                               node(side * i, j + 1, k - 1)});
      }
  const double last = 0.5 * std::numbers::pi * outer / n;
  const auto r = growing(outer - radius, first, step_count(outer - radius, first, last));
  const int layer = static_cast<int>(points.size());
  const int layers = static_cast<int>(r.size()) - 1;
  mesh::Mesh m;
  for (const double distance : r)
    for (const auto& p : points)
      for (const double component : p) m.points.push_back((radius + distance) * component);
  m.blocks.push_back({"fluid", mesh::ElementKind::tet4, {}});
  for (const auto& [a, b, c] : triangles) {
    for (int l = 0; l < layers; ++l)
      add_prism(m.blocks.front(), {a + l * layer, b + l * layer, c + l * layer}, layer);
    add_face(m, "sphere", {a, b, c});
    const double x = points[static_cast<std::size_t>(a)][0] + points[static_cast<std::size_t>(b)][0] +
                     points[static_cast<std::size_t>(c)][0];
    const int top = layers * layer;
    add_face(m, x < 0 ? "inflow" : "outflow", {a + top, b + top, c + top});
  }
  for (int i = -n; i < n; ++i)
    for (int l = 0; l < layers; ++l) {
      const int base = l * layer;
      const int left = n - std::abs(i), right = n - std::abs(i + 1);
      add_side(m, "symmetry_z", base + node(i, left, 0), base + node(i + 1, right, 0), layer);
      add_side(m, "symmetry_y", base + node(i, 0, left), base + node(i + 1, 0, right), layer);
    }
  return m;
}

} // namespace drogue::fluid::test
