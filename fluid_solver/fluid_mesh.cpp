// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/fluid_mesh.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "fluid_solver/simplex_geometry.hpp"

namespace drogue::fluid {
namespace {

using mesh::ElementBlock;
using mesh::ElementKind;

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// Gradients and volume of the cell with these nodes.
template <int dim>
CellGeometry geometry_of(const std::int32_t* nodes, std::span<const double> points) {
  double x[dim + 1][dim];
  for (int a = 0; a <= dim; ++a) std::copy_n(points.data() + 3 * at(nodes[a]), dim, x[a]);
  const SimplexGeometry<dim, double> g = simplex_geometry(x);
  CellGeometry cell;
  cell.volume = g.volume;
  for (int a = 0; a <= dim; ++a) std::copy_n(g.gradient[a], dim, cell.gradient[a]);
  return cell;
}

/// dim! times the signed volume.
template <int dim>
double determinant_of(const std::int32_t* nodes, const double* points) noexcept {
  double e[dim][dim];
  const double* origin = points + 3 * at(nodes[0]);
  for (int k = 0; k < dim; ++k)
    for (int d = 0; d < dim; ++d)
      e[k][d] = points[3 * at(nodes[k + 1]) + static_cast<std::size_t>(d)] - origin[d];
  if constexpr (dim == 2)
    return e[0][0] * e[1][1] - e[0][1] * e[1][0];
  else
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
           e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

CellGeometry geometry_of(int dimension, const std::int32_t* nodes, std::span<const double> points) {
  return dimension == 2 ? geometry_of<2>(nodes, points) : geometry_of<3>(nodes, points);
}

/// Local nodes of the faces of a cell of positive volume, normals outward.
constexpr int faces_of_triangle[3][3] = {{1, 2, -1}, {2, 0, -1}, {0, 1, -1}};
constexpr int faces_of_tet[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

std::array<std::int32_t, 3> face_nodes(const FluidMesh& m, std::int32_t cell, int side) {
  const int* local = m.dimension == 2 ? faces_of_triangle[side] : faces_of_tet[side];
  std::array<std::int32_t, 3> nodes{-1, -1, -1};
  for (std::size_t k = 0; k < static_cast<std::size_t>(m.dimension); ++k)
    nodes[k] = m.cell(cell)[at(local[k])];
  return nodes;
}

struct FaceKey {
  std::array<std::int32_t, 3> sorted{}; ///< starts with -1 in two dimensions
  std::int32_t cell = 0;
  int side = 0;
};

std::array<std::int32_t, 3> sorted(std::array<std::int32_t, 3> nodes) {
  std::sort(nodes.begin(), nodes.end());
  return nodes;
}

/// Faces that belong to one cell only, sorted by their nodes.
std::vector<FaceKey> outer_faces(const FluidMesh& m) {
  std::vector<FaceKey> all;
  all.reserve(m.cells.size());
  for (std::int32_t e = 0; e < m.cell_count(); ++e)
    for (int side = 0; side <= m.dimension; ++side) all.push_back({sorted(face_nodes(m, e, side)), e, side});
  std::sort(all.begin(), all.end(), [](const FaceKey& a, const FaceKey& b) {
    return a.sorted != b.sorted ? a.sorted < b.sorted : a.cell < b.cell;
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

/// What the cells and faces of a mesh are, by dimension.
struct Kinds {
  ElementKind cell;
  ElementKind face;
  const char* cell_name;
  const char* face_name;
};
constexpr Kinds plane{ElementKind::tri3, ElementKind::line2, "triangle", "edge"};
constexpr Kinds space{ElementKind::tet4, ElementKind::tri3, "tetrahedron", "triangle"};

Result<void> find_dimension(FluidMesh& m) {
  const auto has = [&](ElementKind kind) {
    return std::any_of(m.file.blocks.begin(), m.file.blocks.end(),
                       [&](const ElementBlock& b) { return b.kind == kind && b.count() > 0; });
  };
  m.dimension = has(ElementKind::tet4) ? 3 : 2;
  if (m.dimension == 3) return {};
  if (!has(ElementKind::tri3))
    return config_error("the mesh has neither tetrahedra nor triangles: nothing to flow in");
  for (const ElementBlock& block : m.file.blocks)
    for (const std::int32_t node : block.nodes)
      if (m.file.points[3 * at(node) + 2] != m.file.points[2])
        return config_error(
            "the mesh has no tetrahedra, and its triangles do not lie in one plane z = const: "
            "give a volume of tetrahedra, or a plane mesh for a two-dimensional flow");
  return {};
}

/// Collects the cells of the file, renumbered, turned to positive volume and sorted by their smallest nodes.
Result<void> collect_cells(FluidMesh& m) {
  const Kinds& kinds = m.dimension == 2 ? plane : space;
  const std::size_t width = m.cell_nodes();
  std::vector<std::array<std::int32_t, 4>> cells; // in two dimensions three entries are used
  for (const ElementBlock& block : m.file.blocks) {
    if (block.kind == kinds.face || mesh::dimension(block.kind) < m.dimension - 1) continue;
    if (block.kind != kinds.cell)
      return config_error("group \"{}\" has elements of the kind {}; the fluid takes tetrahedra with 3-node "
                          "triangles on the boundary, or triangles with 2-node edges",
                          block.group, mesh::name(block.kind));
    for (std::int32_t e = 0; e < block.count(); ++e) {
      std::array<std::int32_t, 4> t{};
      std::copy_n(block.element(e).begin(), width, t.begin());
      const double v = geometry_of(m.dimension, t.data(), m.file.points).volume;
      if (!(v != 0.0))
        return config_error("{} {} of group \"{}\" has no volume", kinds.cell_name, e, block.group);
      if (v < 0) std::swap(t[width - 2], t[width - 1]);
      cells.push_back(t);
    }
  }
  const auto flatten = [&] {
    m.cells.clear();
    for (const auto& t : cells)
      m.cells.insert(m.cells.end(), t.begin(), t.begin() + static_cast<std::ptrdiff_t>(width));
  };
  flatten();
  m.to_file =
      la::reverse_cuthill_mckee(la::node_graph(m.file.node_count(), m.cells, static_cast<int>(width)));
  m.from_file.resize(m.to_file.size());
  for (std::int32_t i = 0; i < m.node_count(); ++i) m.from_file[at(m.to_file[at(i)])] = i;
  for (auto& t : cells)
    for (std::size_t a = 0; a < width; ++a) t[a] = m.from_file[at(t[a])];
  const auto smallest = [width](const auto& t) {
    return *std::min_element(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(width));
  };
  std::stable_sort(cells.begin(), cells.end(),
                   [&](const auto& a, const auto& b) { return smallest(a) < smallest(b); });
  flatten();
  m.points = m.reordered_from_file(m.file.points, 3);
  m.graph = la::node_graph(m.node_count(), m.cells, static_cast<int>(width));
  return {};
}

Result<void> collect_faces(FluidMesh& m) {
  const Kinds& kinds = m.dimension == 2 ? plane : space;
  const std::vector<FaceKey> outer = outer_faces(m);
  std::vector<char> named(outer.size(), 0);
  for (const ElementBlock& block : m.file.blocks) {
    if (block.kind != kinds.face) continue;
    const auto known = std::find(m.boundaries.begin(), m.boundaries.end(), block.group);
    const auto boundary = static_cast<std::int32_t>(known - m.boundaries.begin());
    if (known == m.boundaries.end()) m.boundaries.push_back(block.group);
    for (std::int32_t e = 0; e < block.count(); ++e) {
      std::array<std::int32_t, 3> key{-1, -1, -1};
      const auto nodes = block.element(e);
      std::transform(nodes.begin(), nodes.end(), key.begin(), [&](auto i) { return m.from_file[at(i)]; });
      key = sorted(key);
      const auto found = std::lower_bound(outer.begin(), outer.end(), key,
                                          [](const FaceKey& f, const auto& k) { return f.sorted < k; });
      if (found == outer.end() || found->sorted != key)
        return config_error("{} {} of boundary \"{}\" is not the face of exactly one {}", kinds.face_name, e,
                            block.group, kinds.cell_name);
      const auto index = static_cast<std::size_t>(found - outer.begin());
      if (named[index])
        return config_error("{} {} of boundary \"{}\" stands in the mesh twice", kinds.face_name, e,
                            block.group);
      named[index] = 1;
      m.faces.push_back({face_nodes(m, found->cell, found->side), static_cast<std::size_t>(m.dimension),
                         found->cell, boundary});
    }
  }
  const auto missing = std::count(named.begin(), named.end(), 0);
  if (missing > 0)
    return config_error("{} faces of the fluid's boundary belong to no named group of {}s", missing,
                        kinds.face_name);
  return {};
}

} // namespace

Result<FluidMesh> FluidMesh::create(mesh::Mesh mesh) {
  FluidMesh m;
  m.hash = mesh::hash(mesh);
  m.file = std::move(mesh);
  DROGUE_TRY(find_dimension(m));
  DROGUE_TRY(collect_cells(m));
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
      nodes.insert(nodes.end(), face.nodes().begin(), face.nodes().end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

std::array<double, 3> area_vector(const BoundaryFace& face, std::span<const double> points) {
  const double* a = points.data() + 3 * at(face.corner[0]);
  const double* b = points.data() + 3 * at(face.corner[1]);
  const double e[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  if (face.corners == 2) return {e[1], -e[0], 0};
  const double* c = points.data() + 3 * at(face.corner[2]);
  const double f[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  return {0.5 * (e[1] * f[2] - e[2] * f[1]), 0.5 * (e[2] * f[0] - e[0] * f[2]),
          0.5 * (e[0] * f[1] - e[1] * f[0])};
}

CellGeometry cell_geometry(const FluidMesh& mesh, std::span<const double> points, std::int32_t cell) {
  return geometry_of(mesh.dimension, mesh.cell(cell).data(), points);
}

double smallest_volume_ratio(const FluidMesh& mesh, std::span<const double> points) {
  const auto smallest = [&]<int dim>() {
    double ratio = std::numeric_limits<double>::infinity();
    for (std::int32_t e = 0; e < mesh.cell_count(); ++e) {
      const std::int32_t* nodes = mesh.cell(e).data();
      ratio = std::min(ratio, determinant_of<dim>(nodes, points.data()) /
                                  determinant_of<dim>(nodes, mesh.points.data()));
    }
    return ratio;
  };
  return mesh.dimension == 2 ? smallest.operator()<2>() : smallest.operator()<3>();
}

} // namespace drogue::fluid
