// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/fluid_mesh.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace drogue::fluid {
namespace {

using mesh::ElementBlock;
using mesh::ElementKind;

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

double volume(std::span<const double> x, const std::int32_t* t) {
  double e[3][3];
  for (int k = 0; k < 3; ++k)
    for (std::size_t d = 0; d < 3; ++d) e[k][d] = x[3 * at(t[k + 1]) + d] - x[3 * at(t[0]) + d];
  return (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
          e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
          e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
         6;
}

/// Faces of a tetrahedron of positive volume, normals outward.
constexpr int outward_face[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

struct FaceKey {
  std::array<std::int32_t, 3> sorted{};
  std::int32_t tet = 0;
  int side = 0;
};

std::array<std::int32_t, 3> sorted(std::array<std::int32_t, 3> nodes) {
  std::sort(nodes.begin(), nodes.end());
  return nodes;
}

/// Faces that belong to one tetrahedron only, sorted by their nodes.
std::vector<FaceKey> outer_faces(std::span<const std::int32_t> tets) {
  std::vector<FaceKey> all;
  all.reserve(tets.size());
  for (std::size_t e = 0; e < tets.size() / 4; ++e)
    for (int side = 0; side < 4; ++side) {
      const auto& f = outward_face[side];
      all.push_back({sorted({tets[4 * e + at(f[0])], tets[4 * e + at(f[1])], tets[4 * e + at(f[2])]}),
                     static_cast<std::int32_t>(e), side});
    }
  std::sort(all.begin(), all.end(), [](const FaceKey& a, const FaceKey& b) {
    return a.sorted != b.sorted ? a.sorted < b.sorted : a.tet < b.tet;
  });
  std::vector<FaceKey> outer;
  for (std::size_t i = 0; i < all.size();) {
    std::size_t j = i + 1;
    while (j < all.size() && all[j].sorted == all[i].sorted) ++j;
    if (j == i + 1) outer.push_back(all[i]);
    i = j;
  }
  return outer;
}

/// Collects the tetrahedra of the file, renumbered, turned to positive volume and sorted by their smallest
/// nodes.
Result<void> collect_tets(FluidMesh& m) {
  std::vector<std::array<std::int32_t, 4>> tets;
  for (const ElementBlock& block : m.file.blocks) {
    if (block.kind == ElementKind::tri3 || mesh::dimension(block.kind) < 2) continue;
    if (block.kind != ElementKind::tet4)
      return config_error(
          "group \"{}\" has elements of the kind {}; the fluid takes tetrahedra and 3-node triangles",
          block.group, mesh::name(block.kind));
    for (std::int32_t e = 0; e < block.count(); ++e) {
      std::array<std::int32_t, 4> t{};
      std::copy_n(block.element(e).begin(), 4, t.begin());
      const double v = volume(m.file.points, t.data());
      if (!(v != 0.0)) return config_error("tetrahedron {} of group \"{}\" has no volume", e, block.group);
      if (v < 0) std::swap(t[2], t[3]);
      tets.push_back(t);
    }
  }
  if (tets.empty()) return config_error("the mesh has no tetrahedra");
  const std::span flat(tets.front().data(), 4 * tets.size());
  m.to_file = la::reverse_cuthill_mckee(la::node_graph(m.file.node_count(), flat, 4));
  m.from_file.resize(m.to_file.size());
  for (std::int32_t i = 0; i < m.node_count(); ++i) m.from_file[at(m.to_file[at(i)])] = i;
  for (auto& t : tets)
    for (std::int32_t& node : t) node = m.from_file[at(node)];
  std::stable_sort(tets.begin(), tets.end(), [](const auto& a, const auto& b) {
    return *std::min_element(a.begin(), a.end()) < *std::min_element(b.begin(), b.end());
  });
  m.tets.assign(flat.begin(), flat.end());
  m.points = m.reordered_from_file(m.file.points, 3);
  m.graph = la::node_graph(m.node_count(), m.tets, 4);
  return {};
}

Result<void> collect_faces(FluidMesh& m) {
  const std::vector<FaceKey> outer = outer_faces(m.tets);
  std::vector<char> named(outer.size(), 0);
  for (const ElementBlock& block : m.file.blocks) {
    if (block.kind != ElementKind::tri3) continue;
    const auto known = std::find(m.boundaries.begin(), m.boundaries.end(), block.group);
    const auto boundary = static_cast<std::int32_t>(known - m.boundaries.begin());
    if (known == m.boundaries.end()) m.boundaries.push_back(block.group);
    for (std::int32_t e = 0; e < block.count(); ++e) {
      const auto nodes = block.element(e);
      const auto key =
          sorted({m.from_file[at(nodes[0])], m.from_file[at(nodes[1])], m.from_file[at(nodes[2])]});
      const auto found = std::lower_bound(outer.begin(), outer.end(), key,
                                          [](const FaceKey& f, const auto& k) { return f.sorted < k; });
      if (found == outer.end() || found->sorted != key)
        return config_error("triangle {} of boundary \"{}\" is not the face of exactly one tetrahedron", e,
                            block.group);
      const auto index = static_cast<std::size_t>(found - outer.begin());
      if (named[index])
        return config_error("triangle {} of boundary \"{}\" stands in the mesh twice", e, block.group);
      named[index] = 1;
      BoundaryFace face{{}, found->tet, boundary};
      for (std::size_t k = 0; k < 3; ++k)
        face.nodes[k] = m.tets[4 * at(found->tet) + at(outward_face[found->side][k])];
      m.faces.push_back(face);
    }
  }
  const auto missing = std::count(named.begin(), named.end(), 0);
  if (missing > 0)
    return config_error("{} faces of the fluid's boundary belong to no named group of triangles", missing);
  return {};
}

} // namespace

Result<FluidMesh> FluidMesh::create(mesh::Mesh mesh) {
  FluidMesh m;
  m.hash = mesh::hash(mesh);
  m.file = std::move(mesh);
  DROGUE_TRY(collect_tets(m));
  DROGUE_TRY(collect_faces(m));
  return m;
}

std::vector<double> FluidMesh::reordered_from_file(std::span<const double> values, int components) const {
  const auto w = static_cast<std::size_t>(components);
  std::vector<double> out(to_file.size() * w);
  for (std::size_t i = 0; i < to_file.size(); ++i)
    std::copy_n(values.data() + at(to_file[i]) * w, w, out.data() + i * w);
  return out;
}

std::vector<double> FluidMesh::reordered_to_file(std::span<const double> values, int components) const {
  const auto w = static_cast<std::size_t>(components);
  std::vector<double> out(to_file.size() * w);
  for (std::size_t i = 0; i < to_file.size(); ++i)
    std::copy_n(values.data() + i * w, w, out.data() + at(to_file[i]) * w);
  return out;
}

std::vector<std::int32_t> FluidMesh::nodes_of(std::span<const std::int32_t> boundary_indices) const {
  std::vector<std::int32_t> nodes;
  for (const BoundaryFace& face : faces)
    if (std::find(boundary_indices.begin(), boundary_indices.end(), face.boundary) != boundary_indices.end())
      nodes.insert(nodes.end(), face.nodes.begin(), face.nodes.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

std::array<double, 3> area_vector(const BoundaryFace& face, std::span<const double> points) {
  const double* a = points.data() + 3 * at(face.nodes[0]);
  const double* b = points.data() + 3 * at(face.nodes[1]);
  const double* c = points.data() + 3 * at(face.nodes[2]);
  const double e[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const double f[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  return {0.5 * (e[1] * f[2] - e[2] * f[1]), 0.5 * (e[2] * f[0] - e[0] * f[2]),
          0.5 * (e[0] * f[1] - e[1] * f[0])};
}

double smallest_volume_ratio(const FluidMesh& mesh, std::span<const double> points) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t e = 0; e < mesh.tets.size(); e += 4)
    smallest =
        std::min(smallest, volume(points, mesh.tets.data() + e) / volume(mesh.points, mesh.tets.data() + e));
  return smallest;
}

} // namespace drogue::fluid
