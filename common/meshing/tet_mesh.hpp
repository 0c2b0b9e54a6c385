// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/mesh.hpp"

namespace drogue::meshing {

using Point = Eigen::Vector3d;
using Tet = std::array<std::int32_t, 4>;
using Triangle = std::array<std::int32_t, 3>;
using Edge = std::array<std::int32_t, 2>;

struct NamedSurface {
  std::string name;
  std::vector<Triangle> triangles; ///< right-handed normal out of the volume
};

/// A volume of tetrahedra, right-handed: the corners 1, 2, 3 turn counter-clockwise seen from outside
/// opposite corner 0 (positive volume).
struct TetMesh {
  std::vector<Point> points;
  std::vector<Tet> tets;
  std::vector<NamedSurface> boundaries;
  /// A surface inside the volume (a membrane) whose triangles are faces of tets on both sides; empty when
  /// there is none, or once its nodes have been doubled.
  std::vector<Triangle> interior;
};

/// Face f of a tet is opposite its corner f, with its normal outward.
[[nodiscard]] constexpr Triangle face_of(const Tet& tet, int f) {
  constexpr int corner[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  const auto at = [&](int i) { return tet[static_cast<std::size_t>(corner[f][i])]; };
  return {at(0), at(1), at(2)};
}

/// The same triangle whatever its orientation and first node.
[[nodiscard]] Triangle sorted(Triangle t);
[[nodiscard]] constexpr Edge sorted(Edge e) {
  return e[0] < e[1] ? e : Edge{e[1], e[0]};
}

/// A tet's face in a list that is sorted by the face's nodes, so that equal faces stand next to each other.
struct FaceRecord {
  Triangle key;
  std::int32_t tet = 0;
  std::int32_t face = 0;
};
[[nodiscard]] std::vector<FaceRecord> sorted_faces(const std::vector<Tet>& tets);

/// Calls visit(first, last) for every run of equal keys in a list sorted by `key`.
template <class Record, class Visit>
void for_equal_keys(const std::vector<Record>& records, Visit visit) {
  for (auto first = records.begin(); first != records.end();) {
    auto last = first;
    while (last != records.end() && last->key == first->key) ++last;
    visit(first, last);
    first = last;
  }
}

/// Tets around each node, compressed rows.
class NodeTets {
 public:
  NodeTets(std::size_t node_count, const std::vector<Tet>& tets);
  [[nodiscard]] std::span<const std::int32_t> of(std::int32_t node) const {
    const auto i = static_cast<std::size_t>(node);
    return {tets_.data() + start_[i], start_[i + 1] - start_[i]};
  }

 private:
  std::vector<std::size_t> start_;
  std::vector<std::int32_t> tets_;
};

/// Turns left-handed tets over and orients the boundary triangles outward.
void orient(TetMesh& m);

/// Loops of edges that belong to one triangle only; two loops never share a node.
[[nodiscard]] std::vector<std::vector<Edge>> free_edge_loops(const std::vector<Triangle>& triangles);

/// As a Mesh: tets in the group `volume_group`, boundaries in the groups of their names.
[[nodiscard]] mesh::Mesh to_mesh(const TetMesh& m, const std::string& volume_group);

/// The four-node tetrahedra of a Mesh, and its three-node triangles as boundaries by the names of their
/// groups.
[[nodiscard]] TetMesh from_mesh(const mesh::Mesh& m);

} // namespace drogue::meshing
