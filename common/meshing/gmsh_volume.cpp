// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/gmsh_volume.hpp"

#include <algorithm>
#include <exception>
#include <iterator>
#include <optional>
#include <thread>
#include <utility>

#include <gmsh.h>

#include "common/mesh/gmsh_session.hpp"

namespace drogue::meshing::gmsh_volume {
namespace {

using Index = std::size_t;
namespace api = gmsh::model::mesh;

constexpr int triangle_type = 2;
constexpr int line_type = 1;
constexpr int tet_type = 4;

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

Result<TetMesh> in_session(const std::function<Result<TetMesh>()>& work) {
  try {
    const mesh::GmshSession session;
    return work();
  } catch (const std::exception& e) {
    return numerical_error("Gmsh cannot mesh the volume: {} ({})", e.what(),
                           mesh::gmsh_reason("no reason given"));
  } catch (...) {
    return numerical_error("Gmsh cannot mesh the volume ({})", mesh::gmsh_reason("no reason given"));
  }
}

} // namespace

void add_surface(int tag, const std::vector<Point>& points, const std::vector<Triangle>& surface,
                 const std::set<std::int32_t>* elsewhere) {
  const std::vector<std::vector<Edge>> loops = free_edge_loops(surface);
  std::vector<int> curves;
  std::set<std::int32_t> inner;
  for (const Triangle& t : surface) inner.insert(t.begin(), t.end());
  if (elsewhere)
    for (const std::int32_t node : *elsewhere) inner.erase(node);
  for (Index i = 0; i < loops.size(); ++i)
    curves.push_back(gmsh::model::addDiscreteEntity(1, tag + 1 + static_cast<int>(i)));
  gmsh::model::addDiscreteEntity(2, tag, curves);
  for (Index i = 0; i < loops.size(); ++i) {
    std::set<std::int32_t> nodes;
    for (const Edge& e : loops[i]) nodes.insert(e.begin(), e.end());
    if (elsewhere)
      for (const std::int32_t node : *elsewhere) nodes.erase(node);
    for (const std::int32_t node : nodes) inner.erase(node);
    add_nodes(1, curves[i], nodes, points);
  }
  add_nodes(2, tag, inner, points);
  for (Index i = 0; i < loops.size(); ++i)
    api::addElementsByType(curves[i], line_type, {},
                           tags(loops[i].front().data(), loops[i].front().data() + 2 * loops[i].size()));
  api::addElementsByType(tag, triangle_type, {},
                         tags(surface.front().data(), surface.front().data() + 3 * surface.size()));
}

void generate(const SizeFunction& size, int dimension) {
  const SizeCallback callback(size);
  gmsh::option::setNumber("General.NumThreads", 1);
  gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 0);
  gmsh::option::setNumber("Mesh.MeshSizeFromPoints", 0);
  gmsh::option::setNumber("Mesh.Renumber", 0);
  gmsh::option::setNumber("Mesh.Algorithm3D", 10);
  gmsh::option::setNumber("Mesh.Optimize", 1);
  gmsh::option::setNumber("Mesh.OptimizeThreshold", 0.35);
  api::generate(dimension);
}

NodeIndex::NodeIndex(std::vector<std::size_t> node_tags) : tags_(std::move(node_tags)) {
  std::sort(tags_.begin(), tags_.end());
}

std::int32_t NodeIndex::operator()(std::size_t tag) const {
  return static_cast<std::int32_t>(std::lower_bound(tags_.begin(), tags_.end(), tag) - tags_.begin());
}

Nodes nodes() {
  std::vector<std::size_t> node_tags;
  std::vector<double> x, parametric;
  api::getNodes(node_tags, x, parametric);
  Nodes nodes{std::vector<Point>(node_tags.size()), NodeIndex(node_tags)};
  for (Index i = 0; i < node_tags.size(); ++i)
    nodes.points[static_cast<Index>(nodes.index(node_tags[i]))] = Point(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
  return nodes;
}

std::vector<Tet> tets(const NodeIndex& index, int volume_tag) {
  return elements<Tet>(index, tet_type, volume_tag);
}

std::vector<Triangle> triangles(const NodeIndex& index, int surface_tag) {
  return elements<Triangle>(index, triangle_type, surface_tag);
}

Result<TetMesh> with_gmsh(const std::function<Result<TetMesh>()>& work) {
  std::optional<Result<TetMesh>> result;
  std::thread worker([&] {
    result = in_session(work);
    if (!result->ok()) mesh::restart_gmsh();
  });
  worker.join();
  return std::move(*result);
}

} // namespace drogue::meshing::gmsh_volume
