// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <set>
#include <vector>

#include "common/base/result.hpp"
#include "common/meshing/tet_mesh.hpp"

namespace drogue::meshing {

using SizeFunction = std::function<double(const Point&)>;

/// What Gmsh's model of a volume is made of; to be used within a mesh::GmshSession. Gmsh's exceptions pass
/// through.
namespace gmsh_volume {

/// Adds triangles as the discrete surface `tag`, bounded by one discrete curve (tag + 1, tag + 2 ...) for
/// each loop of free edges. Nodes in `elsewhere` belong to entities that are there already. Node i gets the
/// tag i + 1.
void add_surface(int tag, const std::vector<Point>& points, const std::vector<Triangle>& surface,
                 const std::set<std::int32_t>* elsewhere = nullptr);

/// Meshes the volumes of the model: HXT, one thread (with more it may give a mesh that does not conform).
/// With `dimension` 2 its surfaces only.
void generate(const SizeFunction& size, int dimension = 3);

/// Node tags to indices from zero, in the order of the tags.
class NodeIndex {
 public:
  explicit NodeIndex(std::vector<std::size_t> node_tags);
  [[nodiscard]] std::int32_t operator()(std::size_t tag) const;

 private:
  std::vector<std::size_t> tags_;
};

/// Positions of all nodes of the model, and their index.
struct Nodes {
  std::vector<Point> points;
  NodeIndex index;
};
[[nodiscard]] Nodes nodes();
[[nodiscard]] std::vector<Tet> tets(const NodeIndex& index, int volume_tag);
[[nodiscard]] std::vector<Triangle> triangles(const NodeIndex& index, int surface_tag);

/// Runs `work` with Gmsh, in a session and a thread of its own. Gmsh hands nodes to HXT in the order of their
/// addresses: the thread allocates from an arena of its own, so that what the process did before (lengths of
/// file names, say) does not change the mesh. Errors (ErrorKind::numerical): those of `work`, and what Gmsh
/// throws.
[[nodiscard]] Result<TetMesh> with_gmsh(const std::function<Result<TetMesh>()>& work);

} // namespace gmsh_volume
} // namespace drogue::meshing
