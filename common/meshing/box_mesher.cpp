// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/box_mesher.hpp"

#include <algorithm>
#include <exception>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include <gmsh.h>

#include "common/mesh/gmsh_session.hpp"

namespace drogue::meshing {
namespace {

using Index = std::size_t;
namespace api = gmsh::model::mesh;

constexpr int triangle_type = 2;
constexpr int line_type = 1;
constexpr int tet_type = 4;
constexpr int membrane_tag = 1000; ///< of the embedded discrete surface; its free edges follow

/// Sizes from a function while this lives.
class SizeCallback {
 public:
  explicit SizeCallback(const SizeFunction& size) {
    api::setSizeCallback([&size](int, int, double x, double y, double z) { return size(Point(x, y, z)); });
  }
  ~SizeCallback() { api::removeSizeCallback(); }
  SizeCallback(const SizeCallback&) = delete;
  SizeCallback& operator=(const SizeCallback&) = delete;
};

std::vector<std::size_t> tags(const std::int32_t* begin, const std::int32_t* end) {
  std::vector<std::size_t> result;
  std::transform(begin, end, std::back_inserter(result),
                 [](auto i) { return static_cast<std::size_t>(i) + 1; });
  return result;
}

void add_nodes(int dim, int tag, const std::set<std::int32_t>& nodes, const std::vector<Point>& points) {
  std::vector<std::size_t> node_tags;
  std::vector<double> coordinates;
  for (const std::int32_t node : nodes) {
    node_tags.push_back(static_cast<std::size_t>(node) + 1);
    const Point& x = points[static_cast<Index>(node)];
    coordinates.insert(coordinates.end(), x.begin(), x.end());
  }
  api::addNodes(dim, tag, node_tags, coordinates);
}

/// The membrane as a discrete surface bounded by one discrete curve for each free-edge loop.
void add_membrane(const std::vector<Point>& points, const std::vector<Triangle>& surface) {
  const std::vector<std::vector<Edge>> loops = free_edge_loops(surface);
  std::vector<int> curves;
  std::set<std::int32_t> inner;
  for (const Triangle& t : surface) inner.insert(t.begin(), t.end());
  for (Index i = 0; i < loops.size(); ++i)
    curves.push_back(gmsh::model::addDiscreteEntity(1, membrane_tag + 1 + static_cast<int>(i)));
  gmsh::model::addDiscreteEntity(2, membrane_tag, curves);
  for (Index i = 0; i < loops.size(); ++i) {
    std::set<std::int32_t> nodes;
    for (const Edge& e : loops[i]) nodes.insert(e.begin(), e.end());
    for (const std::int32_t node : nodes) inner.erase(node);
    add_nodes(1, curves[i], nodes, points);
  }
  add_nodes(2, membrane_tag, inner, points);
  for (Index i = 0; i < loops.size(); ++i)
    api::addElementsByType(curves[i], line_type, {},
                           tags(loops[i].front().data(), loops[i].front().data() + 2 * loops[i].size()));
  api::addElementsByType(membrane_tag, triangle_type, {},
                         tags(surface.front().data(), surface.front().data() + 3 * surface.size()));
}

struct BoxEntities {
  int inflow = 0;
  int outflow = 0;
  std::array<int, 4> sides{};
  int volume = 0;
};

BoxEntities add_box(const Box& box) {
  namespace geo = gmsh::model::geo;
  BoxEntities entities;
  std::array<std::array<int, 4>, 2> corner{}, edge{};
  std::array<int, 4> upright{};
  for (Index level = 0; level < 2; ++level) {
    const double z = level == 0 ? box.low.z() : box.high.z();
    corner[level] = {geo::addPoint(box.low.x(), box.low.y(), z), geo::addPoint(box.high.x(), box.low.y(), z),
                     geo::addPoint(box.high.x(), box.high.y(), z),
                     geo::addPoint(box.low.x(), box.high.y(), z)};
    for (Index i = 0; i < 4; ++i) edge[level][i] = geo::addLine(corner[level][i], corner[level][(i + 1) % 4]);
  }
  for (Index i = 0; i < 4; ++i) upright[i] = geo::addLine(corner[0][i], corner[1][i]);
  const auto plane = [](const std::vector<int>& loop) {
    return geo::addPlaneSurface({geo::addCurveLoop(loop)});
  };
  entities.inflow = plane({edge[0].begin(), edge[0].end()});
  entities.outflow = plane({edge[1].begin(), edge[1].end()});
  for (Index i = 0; i < 4; ++i)
    entities.sides[i] = plane({edge[0][i], upright[(i + 1) % 4], -edge[1][i], -upright[i]});
  std::vector<int> shell{entities.inflow, entities.outflow};
  shell.insert(shell.end(), entities.sides.begin(), entities.sides.end());
  entities.volume = geo::addVolume({geo::addSurfaceLoop(shell)});
  geo::synchronize();
  return entities;
}

void generate(const SizeFunction& size) {
  const SizeCallback callback(size);
  gmsh::option::setNumber("General.NumThreads", 1);
  gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 0);
  gmsh::option::setNumber("Mesh.MeshSizeFromPoints", 0);
  gmsh::option::setNumber("Mesh.Renumber", 0);
  gmsh::option::setNumber("Mesh.Algorithm3D", 10);
  gmsh::option::setNumber("Mesh.Optimize", 1);
  gmsh::option::setNumber("Mesh.OptimizeThreshold", 0.35);
  api::generate(3);
}

/// Node tags to indices from zero, in the order of the tags.
class NodeIndex {
 public:
  explicit NodeIndex(std::vector<std::size_t> node_tags) : tags_(std::move(node_tags)) {
    std::sort(tags_.begin(), tags_.end());
  }
  [[nodiscard]] std::int32_t operator()(std::size_t tag) const {
    return static_cast<std::int32_t>(std::lower_bound(tags_.begin(), tags_.end(), tag) - tags_.begin());
  }

 private:
  std::vector<std::size_t> tags_;
};

template <class Element>
std::vector<Element> elements(const NodeIndex& index, int type, int tag) {
  std::vector<std::size_t> element_tags, nodes;
  api::getElementsByType(type, element_tags, nodes, tag);
  std::vector<Element> result(element_tags.size());
  auto node = nodes.begin();
  for (Element& e : result)
    for (std::int32_t& i : e) i = index(*node++);
  return result;
}

TetMesh collect(const BoxEntities& entities) {
  std::vector<std::size_t> node_tags;
  std::vector<double> x, parametric;
  api::getNodes(node_tags, x, parametric);
  const NodeIndex index(node_tags);
  TetMesh m;
  m.points.resize(node_tags.size());
  for (Index i = 0; i < node_tags.size(); ++i)
    m.points[static_cast<Index>(index(node_tags[i]))] = Point(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
  m.tets = elements<Tet>(index, tet_type, entities.volume);
  m.interior = elements<Triangle>(index, triangle_type, membrane_tag);
  m.boundaries = {{"inflow", elements<Triangle>(index, triangle_type, entities.inflow)},
                  {"outflow", elements<Triangle>(index, triangle_type, entities.outflow)},
                  {"side", {}}};
  for (const int side : entities.sides) {
    const std::vector<Triangle> triangles = elements<Triangle>(index, triangle_type, side);
    m.boundaries.back().triangles.insert(m.boundaries.back().triangles.end(), triangles.begin(),
                                         triangles.end());
  }
  orient(m);
  return m;
}

bool inside(const Box& box, const std::vector<Point>& points) {
  return std::all_of(points.begin(), points.end(), [&](const Point& x) {
    return (x.array() > box.low.array()).all() && (x.array() < box.high.array()).all();
  });
}

bool kept(const TetMesh& m, const std::vector<Point>& points, const std::vector<Triangle>& surface) {
  return m.points.size() > points.size() && std::equal(points.begin(), points.end(), m.points.begin()) &&
         m.interior == surface;
}

Result<TetMesh> mesh_with_gmsh(const Box& box, const std::vector<Point>& points,
                               const std::vector<Triangle>& surface, const SizeFunction& size) {
  try {
    const mesh::GmshSession session;
    add_membrane(points, surface);
    const BoxEntities entities = add_box(box);
    api::embed(2, {membrane_tag}, 3, entities.volume);
    generate(size);
    TetMesh m = collect(entities);
    if (m.tets.empty())
      return numerical_error("Gmsh made no tetrahedra ({})", mesh::gmsh_reason("no reason given"));
    if (!kept(m, points, surface))
      return numerical_error("Gmsh changed the embedded surface ({})", mesh::gmsh_reason("no reason given"));
    return m;
  } catch (const std::exception& e) {
    return numerical_error("Gmsh cannot mesh the volume: {} ({})", e.what(),
                           mesh::gmsh_reason("no reason given"));
  } catch (...) {
    return numerical_error("Gmsh cannot mesh the volume ({})", mesh::gmsh_reason("no reason given"));
  }
}

} // namespace

Result<TetMesh> mesh_box(const Box& box, const std::vector<Point>& points,
                         const std::vector<Triangle>& surface, const SizeFunction& size) {
  if (!inside(box, points)) return numerical_error("the embedded surface is not inside the box");
  // Gmsh hands nodes to HXT in the order of their addresses. A thread of its own allocates from an arena of
  // its own, so that what the process did before (lengths of file names, say) does not change the mesh.
  std::optional<Result<TetMesh>> result;
  std::thread worker([&] { result = mesh_with_gmsh(box, points, surface, size); });
  worker.join();
  return std::move(*result);
}

} // namespace drogue::meshing
