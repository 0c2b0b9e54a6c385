// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/remesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "common/mesh/msh.hpp"
#include "common/meshing/checks.hpp"
#include "common/meshing/disjoint_sets.hpp"
#include "common/meshing/quality.hpp"
#include "common/meshing/repair.hpp"
#include "common/meshing/shell_mesher.hpp"
#include "common/meshing/tet_locator.hpp"

namespace drogue::meshing {
namespace {

using Index = std::size_t;

/// Size with which Gmsh makes tets of the volume of a regular one of edge 1, on parachutes' meshes: so that
/// these keep their number of nodes.
constexpr double size_of_edge = 0.75;
/// Relative difference of the volumes before and after that is rounding.
constexpr double volume_rounding = 1e-9;

Result<std::string> volume_group(const mesh::Mesh& m) {
  std::string group;
  for (const mesh::ElementBlock& block : m.blocks) {
    if (block.kind == mesh::ElementKind::tri3) continue;
    if (block.kind != mesh::ElementKind::tet4)
      return config_error(
          "group \"{}\" has elements of the kind {}: only tetrahedra with 3-node triangles on the "
          "boundary can be meshed anew",
          block.group, mesh::name(block.kind));
    if (!group.empty() && group != block.group)
      return config_error(
          "the tetrahedra are in the groups \"{}\" and \"{}\": only those of one group can be "
          "meshed anew",
          group, block.group);
    group = block.group;
  }
  if (group.empty()) return config_error("the mesh has no tetrahedra");
  return group;
}

double total_volume(const std::vector<Point>& x, const std::vector<Tet>& tets) {
  double sum = 0;
  for (const Tet& tet : tets) sum += volume(x, tet);
  return sum;
}

/// Values of the field "size" anywhere in the old mesh.
class Sizes {
 public:
  Sizes(const TetMesh& old, const TetLocator& locator, const std::vector<double>& values)
      : old_(old),
        locator_(locator),
        values_(values),
        largest_(*std::max_element(values.begin(), values.end())) {}
  double operator()(const Point& x) {
    const TetPlace place = locator_.find(x, last_);
    last_ = place.tet;
    if (place.tet < 0) return largest_;
    double size = 0, weights = 0;
    for (Index a = 0; a < 4; ++a) {
      const double weight = std::max(0.0, place.weight[a]);
      size += weight * values_[static_cast<Index>(old_.tets[static_cast<Index>(place.tet)][a])];
      weights += weight;
    }
    return size / weights;
  }

 private:
  const TetMesh& old_;
  const TetLocator& locator_;
  const std::vector<double>& values_;
  double largest_;
  std::int32_t last_ = -1;
};

/// A part of the volume filled anew: nodes that were there keep their numbers, new ones count from
/// old.points.size().
struct Filling {
  std::vector<Point> points; ///< the new ones
  std::vector<Tet> tets;
};

/// Faces that belong to one tet only.
std::vector<Triangle> outer_faces(const std::vector<Tet>& tets) {
  std::vector<Triangle> faces;
  for_equal_keys(sorted_faces(tets), [&](auto first, auto last) {
    if (last - first == 1) faces.push_back(face_of(tets[static_cast<Index>(first->tet)], first->face));
  });
  return faces;
}

/// Fills the volume of some tets anew, `first_new` being the number of its first new node.
Result<Filling> fill(const TetMesh& old, const std::vector<Tet>& tets, std::int32_t first_new,
                     const SizeFunction& size) {
  const TetMesh hollow{old.points, {}, {{"outer", outer_faces(tets)}}, {}};
  const auto surface = merge_sides(hollow);
  if (!surface) return surface.error();
  auto filled = mesh_shells(*surface, size);
  if (!filled) return filled.error();
  (void)split_bridges(*filled);
  (void)smooth_bad_tets(*filled, 0.25, 8);
  (void)smooth_bad_tets(*filled, 0.35, 4);
  const Index merged = surface->points.size();
  Filling result;
  result.points.assign(filled->points.begin() + static_cast<std::ptrdiff_t>(merged), filled->points.end());
  result.tets = filled->tets;
  DROGUE_TRY(restore_sides(*surface, result.tets));
  for (Index e = 0; e < result.tets.size(); ++e)
    for (Index c = 0; c < 4; ++c)
      if (const auto node = static_cast<Index>(filled->tets[e][c]); node >= merged)
        result.tets[e][c] = first_new + static_cast<std::int32_t>(node - merged);
  return result;
}

void mark_around(const TetMesh& m, const std::vector<char>& nodes, std::vector<char>& in) {
  for (Index e = 0; e < m.tets.size(); ++e)
    if (std::any_of(m.tets[e].begin(), m.tets[e].end(),
                    [&](auto node) { return nodes[static_cast<Index>(node)]; }))
      in[e] = 1;
}

/// Nodes around which the marked tets, or the others, do not hang together through faces.
std::vector<char> pinches(const TetMesh& m, const std::vector<FaceRecord>& faces,
                          const std::vector<char>& in) {
  DisjointSets corners(4 * m.tets.size());
  const auto corner = [&](std::int32_t e, std::int32_t node) {
    const Tet& tet = m.tets[static_cast<Index>(e)];
    return 4 * e + static_cast<std::int32_t>(std::find(tet.begin(), tet.end(), node) - tet.begin());
  };
  for_equal_keys(faces, [&](auto first, auto last) {
    if (last - first == 2 && in[static_cast<Index>(first->tet)] == in[static_cast<Index>((first + 1)->tet)])
      for (const std::int32_t node : first->key)
        corners.unite(corner(first->tet, node), corner((first + 1)->tet, node));
  });
  std::vector<std::array<std::int32_t, 2>> regions(m.points.size());
  for (Index e = 0; e < m.tets.size(); ++e)
    for (Index c = 0; c < 4; ++c)
      if (const auto i = static_cast<std::int32_t>(4 * e + c); corners.find(i) == i)
        ++regions[static_cast<Index>(m.tets[e][c])][in[e] ? 1 : 0];
  std::vector<char> pinched(m.points.size(), 0);
  for (Index i = 0; i < pinched.size(); ++i)
    pinched[i] = regions[i][1] > 0 && (regions[i][0] > 1 || regions[i][1] > 1);
  return pinched;
}

/// Tets with a worn node, and what else it takes for their surface not to touch itself.
std::vector<char> worn_tets(const TetMesh& m, const mesh::NodeField& worn) {
  std::vector<char> nodes(m.points.size(), 0), in(m.tets.size(), 0);
  for (Index i = 0; i < nodes.size(); ++i) nodes[i] = worn.values[i] > 0 ? 1 : 0;
  mark_around(m, nodes, in);
  const std::vector<FaceRecord> faces = sorted_faces(m.tets);
  for (auto before = std::ptrdiff_t{-1}, now = std::count(in.begin(), in.end(), 1); now > before;
       before = now, now = std::count(in.begin(), in.end(), 1))
    mark_around(m, pinches(m, faces, in), in);
  return in;
}

/// The marked tets, those that hang together through faces at a time.
std::vector<std::vector<Tet>> cavities_of(const TetMesh& m, const std::vector<char>& in) {
  DisjointSets sets(m.tets.size());
  for_equal_keys(sorted_faces(m.tets), [&](auto first, auto last) {
    if (last - first == 2 && in[static_cast<Index>(first->tet)] && in[static_cast<Index>((first + 1)->tet)])
      sets.unite(first->tet, (first + 1)->tet);
  });
  std::map<std::int32_t, std::vector<Tet>> cavities;
  for (Index e = 0; e < m.tets.size(); ++e)
    if (in[e]) cavities[sets.find(static_cast<std::int32_t>(e))].push_back(m.tets[e]);
  std::vector<std::vector<Tet>> result;
  for (auto& [representative, tets] : cavities) result.push_back(std::move(tets));
  return result;
}

/// The mesh with some of its tets replaced, and where its nodes were.
struct Refilled {
  TetMesh mesh;
  std::vector<std::int32_t> previous; ///< {nodes}: old node; -1: a new one. Ascending, the new ones last
};

Refilled numbered(const TetMesh& old, const std::vector<Point>& new_points, std::vector<Tet> tets) {
  std::vector<std::int32_t> number(old.points.size() + new_points.size(), -1);
  for (const Tet& tet : tets)
    for (const std::int32_t node : tet) number[static_cast<Index>(node)] = 0;
  Refilled r;
  for (Index i = 0; i < number.size(); ++i) {
    if (number[i] < 0) continue;
    number[i] = static_cast<std::int32_t>(r.previous.size());
    const bool is_old = i < old.points.size();
    r.previous.push_back(is_old ? static_cast<std::int32_t>(i) : -1);
    r.mesh.points.push_back(is_old ? old.points[i] : new_points[i - old.points.size()]);
  }
  const auto renumber = [&](auto& nodes) {
    for (std::int32_t& node : nodes) node = number[static_cast<Index>(node)];
  };
  for (Tet& tet : tets) renumber(tet);
  r.mesh.tets = std::move(tets);
  r.mesh.boundaries = old.boundaries;
  for (NamedSurface& boundary : r.mesh.boundaries)
    for (Triangle& t : boundary.triangles) renumber(t);
  return r;
}

Result<void> check(const TetMesh& m, const TetMesh& old) {
  DROGUE_TRY(check_volume(m));
  const double before = total_volume(old.points, old.tets), after = total_volume(m.points, m.tets);
  if (std::abs(after - before) > volume_rounding * before)
    return numerical_error("the new mesh fills a volume of {:.12g} in place of {:.12g}", after, before);
  return {};
}

/// Replaces the marked tets.
Result<Refilled> refill(const TetMesh& old, const std::vector<char>& in, const SizeFunction& size) {
  std::vector<Tet> tets;
  for (Index e = 0; e < old.tets.size(); ++e)
    if (!in[e]) tets.push_back(old.tets[e]);
  std::vector<Point> new_points;
  for (const std::vector<Tet>& cavity : cavities_of(old, in)) {
    const auto filling =
        fill(old, cavity, static_cast<std::int32_t>(old.points.size() + new_points.size()), size);
    if (!filling) return filling.error();
    new_points.insert(new_points.end(), filling->points.begin(), filling->points.end());
    tets.insert(tets.end(), filling->tets.begin(), filling->tets.end());
  }
  Refilled result = numbered(old, new_points, std::move(tets));
  DROGUE_TRY(check(result.mesh, old));
  return result;
}

mesh::NodeField carried(const mesh::NodeField& field, const TetMesh& old, const TetLocator& locator,
                        const Refilled& r) {
  const auto width = static_cast<Index>(field.components);
  mesh::NodeField result{field.components, {}};
  result.values.reserve(width * r.previous.size());
  std::int32_t last = -1;
  for (Index i = 0; i < r.previous.size(); ++i) {
    if (r.previous[i] >= 0) {
      const auto from = field.values.begin() + static_cast<std::ptrdiff_t>(width) * r.previous[i];
      result.values.insert(result.values.end(), from, from + static_cast<std::ptrdiff_t>(width));
      continue;
    }
    const TetPlace place = locator.find(r.mesh.points[i], last);
    last = place.tet;
    for (Index k = 0; k < width; ++k) {
      double value = place.tet < 0 ? std::numeric_limits<double>::quiet_NaN() : 0.0;
      for (Index a = 0; a < 4 && place.tet >= 0; ++a)
        value += place.weight[a] *
                 field.values[width * static_cast<Index>(old.tets[static_cast<Index>(place.tet)][a]) + k];
      result.values.push_back(value);
    }
  }
  return result;
}

} // namespace

mesh::NodeField sizes_of(const mesh::Mesh& mesh, std::span<const double> points) {
  std::vector<double> sum(points.size() / 3, 0.0), count = sum;
  const auto at = [&](std::int32_t node) {
    const double* x = points.data() + 3 * static_cast<Index>(node);
    return Point(x[0], x[1], x[2]);
  };
  for (const mesh::ElementBlock& block : mesh.blocks) {
    if (block.kind != mesh::ElementKind::tet4) continue;
    for (std::int32_t e = 0; e < block.count(); ++e) {
      const auto tet = block.element(e);
      const Point o = at(tet[0]);
      const double six_volumes = std::abs((at(tet[1]) - o).dot((at(tet[2]) - o).cross(at(tet[3]) - o)));
      for (const std::int32_t node : tet) {
        sum[static_cast<Index>(node)] += six_volumes;
        count[static_cast<Index>(node)] += 1;
      }
    }
  }
  for (Index i = 0; i < sum.size(); ++i)
    sum[i] = size_of_edge * std::cbrt(std::numbers::sqrt2 * sum[i] / std::max(count[i], 1.0));
  return {1, std::move(sum)};
}

Result<mesh::Mesh> remesh(const mesh::Mesh& old_mesh) {
  const auto group = volume_group(old_mesh);
  if (!group) return group.error();
  TetMesh old = from_mesh(old_mesh);
  orient(old);
  const TetLocator locator(old.points, old.tets);
  mesh::NodeField size = sizes_of(old_mesh, old_mesh.points);
  if (const auto given = old_mesh.node_fields.find(size_field_name); given != old_mesh.node_fields.end())
    size = given->second;
  Sizes sizes(old, locator, size.values);
  const auto size_at = [&](const Point& x) { return sizes(x); };
  const std::vector<char> all(old.tets.size(), 1);
  const auto worn = old_mesh.node_fields.find(worn_field_name);
  auto made = refill(old, worn == old_mesh.node_fields.end() ? all : worn_tets(old, worn->second), size_at);
  if (!made && worn != old_mesh.node_fields.end()) made = refill(old, all, size_at);
  if (!made) return made.error();
  mesh::Mesh result = to_mesh(made->mesh, *group);
  for (const auto& [name, field] : old_mesh.node_fields)
    if (name != size_field_name && name != worn_field_name && name != previous_field_name)
      result.node_fields[name] = carried(field, old, locator, *made);
  result.node_fields[size_field_name] = carried(size, old, locator, *made);
  mesh::NodeField& previous = result.node_fields[previous_field_name];
  for (const std::int32_t node : made->previous)
    previous.values.push_back(node < 0 ? std::numeric_limits<double>::quiet_NaN() : node);
  return result;
}

Result<void> remesh_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  const auto old = mesh::read_msh(from);
  if (!old) return old.error();
  const auto made = remesh(*old);
  if (!made) return made.error();
  return mesh::write_msh(to, *made);
}

} // namespace drogue::meshing
