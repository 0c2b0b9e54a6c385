// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/tet_mesh.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "common/meshing/disjoint_sets.hpp"
#include "common/meshing/quality.hpp"

namespace drogue::meshing {
namespace {

struct EdgeRecord {
  Edge key;
};

std::vector<Edge> free_edges(const std::vector<Triangle>& triangles) {
  std::vector<EdgeRecord> edges;
  for (const Triangle& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) edges.push_back({sorted(Edge{t[i], t[(i + 1) % 3]})});
  std::sort(edges.begin(), edges.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
  std::vector<Edge> free;
  for_equal_keys(edges, [&](auto first, auto last) {
    if (last - first == 1) free.push_back(first->key);
  });
  return free;
}

mesh::ElementBlock block_of(const NamedSurface& surface) {
  mesh::ElementBlock block{surface.name, mesh::ElementKind::tri3, {}};
  for (const Triangle& t : surface.triangles) block.nodes.insert(block.nodes.end(), t.begin(), t.end());
  return block;
}

template <class Element>
void append(const mesh::ElementBlock& block, std::vector<Element>& elements) {
  for (std::int32_t e = 0; e < block.count(); ++e) {
    const auto nodes = block.element(e);
    std::copy(nodes.begin(), nodes.end(), elements.emplace_back().begin());
  }
}

} // namespace

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

std::vector<FaceRecord> sorted_faces(const std::vector<Tet>& tets) {
  std::vector<FaceRecord> faces;
  faces.reserve(4 * tets.size());
  for (std::size_t e = 0; e < tets.size(); ++e)
    for (int f = 0; f < 4; ++f)
      faces.push_back({sorted(face_of(tets[e], f)), static_cast<std::int32_t>(e), f});
  std::sort(faces.begin(), faces.end(), [](const FaceRecord& a, const FaceRecord& b) {
    return a.key != b.key ? a.key < b.key : a.tet < b.tet;
  });
  return faces;
}

NodeTets::NodeTets(std::size_t node_count, const std::vector<Tet>& tets)
    : start_(node_count + 1, 0), tets_(4 * tets.size()) {
  for (const Tet& t : tets)
    for (const std::int32_t node : t) ++start_[static_cast<std::size_t>(node) + 1];
  for (std::size_t i = 0; i < node_count; ++i) start_[i + 1] += start_[i];
  std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
  for (std::size_t e = 0; e < tets.size(); ++e)
    for (const std::int32_t node : tets[e])
      tets_[next[static_cast<std::size_t>(node)]++] = static_cast<std::int32_t>(e);
}

void orient(TetMesh& m) {
  for (Tet& tet : m.tets)
    if (volume(m.points, tet) < 0) std::swap(tet[0], tet[1]);
  std::map<Triangle, Triangle> outward;
  for_equal_keys(sorted_faces(m.tets), [&](auto first, auto last) {
    if (last - first == 1)
      outward.emplace(first->key, face_of(m.tets[static_cast<std::size_t>(first->tet)], first->face));
  });
  for (NamedSurface& surface : m.boundaries)
    for (Triangle& t : surface.triangles)
      if (const auto it = outward.find(sorted(t)); it != outward.end()) t = it->second;
}

std::vector<std::vector<Edge>> free_edge_loops(const std::vector<Triangle>& triangles) {
  const std::vector<Edge> edges = free_edges(triangles);
  std::int32_t largest = 0;
  for (const Edge& e : edges) largest = std::max(largest, e[1]);
  DisjointSets sets(static_cast<std::size_t>(largest) + 1);
  for (const Edge& e : edges) sets.unite(e[0], e[1]);
  std::map<std::int32_t, std::vector<Edge>> loops;
  for (const Edge& e : edges) loops[sets.find(e[0])].push_back(e);
  std::vector<std::vector<Edge>> result;
  for (auto& [representative, loop] : loops) result.push_back(std::move(loop));
  return result;
}

mesh::Mesh to_mesh(const TetMesh& m, const std::string& volume_group) {
  mesh::Mesh result;
  for (const Point& x : m.points) result.points.insert(result.points.end(), x.begin(), x.end());
  for (const NamedSurface& surface : m.boundaries) result.blocks.push_back(block_of(surface));
  mesh::ElementBlock volume{volume_group, mesh::ElementKind::tet4, {}};
  for (const Tet& tet : m.tets) volume.nodes.insert(volume.nodes.end(), tet.begin(), tet.end());
  result.blocks.push_back(std::move(volume));
  return result;
}

TetMesh from_mesh(const mesh::Mesh& m) {
  TetMesh result;
  for (std::size_t i = 0; i < m.points.size(); i += 3)
    result.points.emplace_back(m.points[i], m.points[i + 1], m.points[i + 2]);
  for (const mesh::ElementBlock& block : m.blocks) {
    if (block.kind == mesh::ElementKind::tet4) append(block, result.tets);
    if (block.kind == mesh::ElementKind::tri3)
      append(block, result.boundaries.emplace_back(NamedSurface{block.group, {}}).triangles);
  }
  return result;
}

} // namespace drogue::meshing
