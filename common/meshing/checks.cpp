// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/checks.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/meshing/disjoint_sets.hpp"
#include "common/meshing/quality.hpp"

namespace drogue::meshing {
namespace {

using Index = std::size_t;

/// The triangle with its smallest node first: equal exactly when orientation and nodes are.
Triangle canonical(const Triangle& t) {
  const auto i = static_cast<Index>(std::min_element(t.begin(), t.end()) - t.begin());
  return {t[i], t[(i + 1) % 3], t[(i + 2) % 3]};
}

template <std::size_t N>
std::string name(const TetMesh& m, const char* what, const std::array<std::int32_t, N>& nodes) {
  Point centre = Point::Zero();
  for (const std::int32_t node : nodes) centre += m.points[static_cast<Index>(node)] / static_cast<double>(N);
  return fmt::format("{} of the nodes {} at ({:.6g}, {:.6g}, {:.6g})", what, fmt::join(nodes, ", "),
                     centre.x(), centre.y(), centre.z());
}

Result<void> check_volumes(const TetMesh& m) {
  const auto is_flat = [&](const Tet& tet) { return !(volume(m.points, tet) > 0); };
  const auto flat = std::count_if(m.tets.begin(), m.tets.end(), is_flat);
  if (flat == 0) return {};
  return numerical_error("{} of {} tetrahedra have no positive volume; the first is the {}", flat,
                         m.tets.size(),
                         name(m, "tetrahedron", *std::find_if(m.tets.begin(), m.tets.end(), is_flat)));
}

Result<void> check_faces(const TetMesh& m, const std::vector<FaceRecord>& faces) {
  std::vector<Triangle> expected, found;
  for (const NamedSurface& surface : m.boundaries)
    for (const Triangle& t : surface.triangles) expected.push_back(canonical(t));
  std::int32_t crowded = 0;
  Triangle first_crowded{};
  for_equal_keys(faces, [&](auto first, auto last) {
    if (last - first > 2 && crowded++ == 0) first_crowded = first->key;
    if (last - first == 1)
      found.push_back(canonical(face_of(m.tets[static_cast<Index>(first->tet)], first->face)));
  });
  if (crowded > 0)
    return numerical_error("{} faces belong to more than two tetrahedra; the first is the {}", crowded,
                           name(m, "face", first_crowded));
  std::sort(expected.begin(), expected.end());
  std::sort(found.begin(), found.end());
  if (expected == found) return {};
  std::vector<Triangle> missing, extra;
  std::set_difference(expected.begin(), expected.end(), found.begin(), found.end(),
                      std::back_inserter(missing));
  std::set_difference(found.begin(), found.end(), expected.begin(), expected.end(),
                      std::back_inserter(extra));
  return numerical_error(
      "the mesh is not conforming: {} faces of a single tetrahedron are in no named boundary, and "
      "{} boundary triangles are no such face; the first is the {}",
      extra.size(), missing.size(), name(m, "triangle", extra.empty() ? missing.front() : extra.front()));
}

Result<void> check_nodes(const TetMesh& m, const std::vector<FaceRecord>& faces) {
  DisjointSets corners(4 * m.tets.size());
  const auto corner = [&](std::int32_t e, std::int32_t node) {
    const Tet& tet = m.tets[static_cast<Index>(e)];
    return 4 * e + static_cast<std::int32_t>(std::find(tet.begin(), tet.end(), node) - tet.begin());
  };
  for_equal_keys(faces, [&](auto first, auto last) {
    if (last - first == 2)
      for (const std::int32_t node : first->key)
        corners.unite(corner(first->tet, node), corner((first + 1)->tet, node));
  });
  std::vector<std::int32_t> regions(m.points.size(), 0);
  for (Index e = 0; e < m.tets.size(); ++e)
    for (std::int32_t c = 0; c < 4; ++c) {
      const std::int32_t i = 4 * static_cast<std::int32_t>(e) + c;
      if (corners.find(i) == i) ++regions[static_cast<Index>(m.tets[e][static_cast<Index>(c)])];
    }
  const auto first_node = [&](auto matches) {
    const auto i = std::find_if(regions.begin(), regions.end(), matches) - regions.begin();
    return name(m, "one", std::array{static_cast<std::int32_t>(i)});
  };
  const auto none = [](std::int32_t n) { return n == 0; };
  const auto several = [](std::int32_t n) { return n > 1; };
  if (const auto orphans = std::count_if(regions.begin(), regions.end(), none); orphans > 0)
    return numerical_error("{} nodes belong to no tetrahedron; the first is the {}", orphans,
                           first_node(none));
  if (const auto pinched = std::count_if(regions.begin(), regions.end(), several); pinched > 0)
    return numerical_error(
        "the tetrahedra around {} nodes are not connected through faces; the first is the {}", pinched,
        first_node(several));
  return {};
}

} // namespace

Result<void> check_volume(const TetMesh& m) {
  const std::vector<FaceRecord> faces = sorted_faces(m.tets);
  DROGUE_TRY(check_volumes(m));
  DROGUE_TRY(check_faces(m, faces));
  return check_nodes(m, faces);
}

std::int32_t euler_characteristic(const std::vector<Triangle>& triangles) {
  std::vector<std::int32_t> nodes;
  std::vector<Edge> edges;
  for (const Triangle& t : triangles)
    for (Index i = 0; i < 3; ++i) {
      nodes.push_back(t[i]);
      edges.push_back(sorted(Edge{t[i], t[(i + 1) % 3]}));
    }
  const auto distinct = [](auto& values) {
    std::sort(values.begin(), values.end());
    return static_cast<std::int32_t>(std::unique(values.begin(), values.end()) - values.begin());
  };
  return distinct(nodes) - distinct(edges) + static_cast<std::int32_t>(triangles.size());
}

std::int32_t piece_count(const std::vector<Triangle>& triangles) {
  std::int32_t largest = -1;
  for (const Triangle& t : triangles) largest = std::max({largest, t[0], t[1], t[2]});
  DisjointSets sets(static_cast<Index>(largest) + 1);
  for (const Triangle& t : triangles)
    for (Index i = 1; i < 3; ++i) sets.unite(t[0], t[i]);
  std::set<std::int32_t> pieces;
  for (const Triangle& t : triangles) pieces.insert(sets.find(t[0]));
  return static_cast<std::int32_t>(pieces.size());
}

Result<void> check_two_sided(const std::vector<Triangle>& upper, const std::vector<Triangle>& lower) {
  std::vector<Triangle> both = upper;
  both.insert(both.end(), lower.begin(), lower.end());
  std::map<Edge, std::array<int, 2>> edges; // how often in each direction
  for (const Triangle& t : both)
    for (Index i = 0; i < 3; ++i) {
      const Edge e{t[i], t[(i + 1) % 3]};
      ++edges[sorted(e)][e[0] < e[1] ? 0 : 1];
    }
  const auto is_open = [](const auto& e) { return e.second != std::array{1, 1}; };
  if (const auto open = std::count_if(edges.begin(), edges.end(), is_open); open > 0) {
    const Edge& first = std::find_if(edges.begin(), edges.end(), is_open)->first;
    return numerical_error(
        "the two sides of the membrane do not close: {} edges do not belong to two triangles in "
        "opposite directions; the first is the edge between the nodes {} and {}",
        open, first[0], first[1]);
  }
  const auto loops = static_cast<std::int32_t>(free_edge_loops(upper).size());
  const std::int32_t expected = 4 * piece_count(upper) - 2 * loops, found = euler_characteristic(both);
  if (found != expected)
    return numerical_error(
        "the two sides of the membrane have Euler characteristic {} instead of {} ({} free edge "
        "loops)",
        found, expected, loops);
  return {};
}

} // namespace drogue::meshing
