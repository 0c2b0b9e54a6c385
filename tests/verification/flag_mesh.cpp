// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmsh.h>

#include <algorithm>
#include <cmath>

#include "common/mesh/gmsh_session.hpp"
#include "tests/verification/fluid_meshes.hpp"
#include "tests/verification/plane_mesh.hpp"

namespace drogue::fluid::test {
namespace {

namespace geo = gmsh::model::geo;

constexpr double axis = 0.2;
constexpr double top = 0.41;
constexpr double same = 1e-12; ///< distances below are none

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

/// What lies below the axis; groups fluid, bottom, outflow, inflow, obstacle, and plate when it is apart.
mesh::Mesh lower_half(const PlaneSize& size, bool flag_apart) {
  const mesh::GmshSession session;
  constexpr double radius = 0.05, half = 0.01, end = 0.6;
  const double root = axis + std::sqrt(radius * radius - half * half);
  const std::vector<std::array<double, 2>> corners = {{0, 0},
                                                      {2.5, 0},
                                                      {2.5, axis},
                                                      {end, axis},
                                                      {end, axis - half},
                                                      {root, axis - half},
                                                      {0.2, axis - radius},
                                                      {0.2 - radius, axis},
                                                      {0, axis}};
  const int centre = geo::addPoint(0.2, axis, 0);
  std::vector<int> points, curves;
  for (const auto& [x, y] : corners) points.push_back(geo::addPoint(x, y, 0));
  for (std::size_t k = 0; k < points.size(); ++k) {
    const int from = points[k], to = points[(k + 1) % points.size()];
    curves.push_back(k == 5 || k == 6 ? geo::addCircleArc(from, centre, to) : geo::addLine(from, to));
  }
  const int surface = geo::addPlaneSurface({geo::addCurveLoop(curves)});
  geo::synchronize();
  std::vector<std::pair<std::string, std::vector<int>>> groups{
      {"bottom", {curves[0]}}, {"outflow", {curves[1]}}, {"inflow", {curves[8]}}};
  const std::vector<int> flag{curves[3], curves[4]}, cylinder{curves[5], curves[6]};
  if (flag_apart) {
    groups.push_back({"obstacle", cylinder});
    groups.push_back({"plate", flag});
  } else {
    groups.push_back({"obstacle", {flag[0], flag[1], cylinder[0], cylinder[1]}});
  }
  return triangulated(surface, groups, size);
}

std::vector<std::int32_t>& nodes_of(mesh::Mesh& m, const std::string& group) {
  return std::find_if(m.blocks.begin(), m.blocks.end(), [&](const auto& b) { return b.group == group; })
      ->nodes;
}

/// Adds the mirror image. Returns the images of the bottom's nodes, from left to right.
std::vector<std::int32_t> add_image(mesh::Mesh& m) {
  const mesh::Mesh half = m;
  std::vector<std::int32_t> image, line;
  for (int i = 0; i < half.node_count(); ++i) {
    const double x = half.points[3 * at(i)], y = half.points[3 * at(i) + 1];
    const bool on_axis = std::abs(y - axis) < same;
    image.push_back(on_axis ? i : m.node_count());
    if (!on_axis) m.points.insert(m.points.end(), {x, 2 * axis - y, 0.0});
    if (y < same) line.push_back(image.back());
  }
  for (const auto& block : half.blocks)
    if (block.group != "bottom")
      for (std::int32_t e = 0; e < block.count(); ++e) {
        const auto element = block.element(e);
        for (auto node = element.rbegin(); node != element.rend(); ++node)
          nodes_of(m, block.group).push_back(image[at(*node)]);
      }
  std::sort(line.begin(), line.end(),
            [&](std::int32_t a, std::int32_t b) { return m.points[3 * at(a)] < m.points[3 * at(b)]; });
  return line;
}

} // namespace

mesh::Mesh mirrored_flag_in_channel(const FlagSizes& sizes, bool flag_apart) {
  mesh::Mesh m = lower_half(flag_sizes(sizes), flag_apart);
  std::vector<std::int32_t> line = add_image(m);
  m.blocks.push_back({"top", mesh::ElementKind::line2, {}});
  const auto add = [&](const std::string& group, std::initializer_list<std::int32_t> nodes) {
    auto& to = nodes_of(m, group);
    to.insert(to.end(), nodes);
  };
  // what is left up to the channel's upper wall, in layers
  const double height = top - 2 * axis;
  const int layers = std::max(1, static_cast<int>(std::lround(height / sizes.bulk)));
  for (int k = 1; k <= layers; ++k) {
    std::vector<std::int32_t> next;
    for (const std::int32_t i : line) {
      next.push_back(m.node_count());
      m.points.insert(m.points.end(), {double{m.points[3 * at(i)]}, 2 * axis + height * k / layers, 0.0});
    }
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      add("fluid", {line[i], line[i + 1], next[i + 1]});
      add("fluid", {line[i], next[i + 1], next[i]});
      if (k == layers) add("top", {next[i + 1], next[i]});
    }
    add("inflow", {next.front(), line.front()});
    add("outflow", {line.back(), next.back()});
    line = next;
  }
  return m;
}

} // namespace drogue::fluid::test
