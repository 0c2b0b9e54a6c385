// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/remesh.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "common/mesh/msh.hpp"
#include "common/meshing/checks.hpp"
#include "common/meshing/quality.hpp"
#include "common/meshing/refill.hpp"
#include "common/meshing/remesh_plane.hpp"
#include "common/meshing/repair.hpp"
#include "common/meshing/shell_mesher.hpp"

namespace drogue::meshing {
namespace {

using Index = std::size_t;

/// Size with which Gmsh makes tets of the volume of a regular one of edge 1, on parachutes' meshes: so that
/// these keep their number of nodes.
constexpr double size_of_edge = 0.75;
/// Relative difference of the volumes before and after that is rounding.
constexpr double volume_rounding = 1e-9;

bool has_tets(const mesh::Mesh& m) {
  return std::any_of(m.blocks.begin(), m.blocks.end(),
                     [](const mesh::ElementBlock& block) { return block.kind == mesh::ElementKind::tet4; });
}

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
  return group;
}

double total_volume(const std::vector<Point>& x, const std::vector<Tet>& tets) {
  double sum = 0;
  for (const Tet& tet : tets) sum += volume(x, tet);
  return sum;
}

/// Faces that belong to one tet only.
std::vector<Triangle> outer_faces(const std::vector<Tet>& tets) {
  std::vector<Triangle> faces;
  for_equal_keys(sorted_faces(tets), [&](auto first, auto last) {
    if (last - first == 1) faces.push_back(face_of(tets[static_cast<Index>(first->tet)], first->face));
  });
  return faces;
}

/// Fills the volume of some tets anew, `first_new` being the number of its first new node.
Result<refill::Filling<3>> fill(const TetMesh& old, const std::vector<Tet>& tets, std::int32_t first_new,
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
  refill::Filling<3> result;
  result.points.assign(filled->points.begin() + static_cast<std::ptrdiff_t>(merged), filled->points.end());
  result.cells = filled->tets;
  DROGUE_TRY(restore_sides(*surface, result.cells));
  for (Index e = 0; e < result.cells.size(); ++e)
    for (Index c = 0; c < 4; ++c)
      if (const auto node = static_cast<Index>(filled->tets[e][c]); node >= merged)
        result.cells[e][c] = first_new + static_cast<std::int32_t>(node - merged);
  return result;
}

Result<void> check(const TetMesh& m, const TetMesh& old) {
  DROGUE_TRY(check_volume(m));
  const double before = total_volume(old.points, old.tets), after = total_volume(m.points, m.tets);
  if (std::abs(after - before) > volume_rounding * before)
    return numerical_error("the new mesh fills a volume of {:.12g} in place of {:.12g}", after, before);
  return {};
}

/// Boundaries with the nodes' new numbers.
std::vector<NamedSurface> boundaries_of(const TetMesh& old, const std::vector<std::int32_t>& number) {
  std::vector<NamedSurface> boundaries = old.boundaries;
  for (NamedSurface& boundary : boundaries)
    for (Triangle& t : boundary.triangles)
      for (std::int32_t& node : t) node = number[static_cast<Index>(node)];
  return boundaries;
}

Result<mesh::Mesh> remesh_volume(const mesh::Mesh& old_mesh) {
  const auto group = volume_group(old_mesh);
  if (!group) return group.error();
  TetMesh old = from_mesh(old_mesh);
  orient(old);
  const refill::Simplices<3> cells{old.points, old.tets};
  const TetLocator locator(cells.points, cells.cells);
  const mesh::NodeField size = refill::size_field(old_mesh);
  refill::Sizes<3> sizes(cells.cells, locator, size.values);
  const auto size_at = [&](const Point& x) { return sizes(x); };
  TetMesh mesh;
  const auto made = refill::refilled_where_worn<3>(
      old_mesh, cells, [&](const std::vector<char>& in) -> Result<refill::Refilled<3>> {
        auto r = refill::replaced<3>(cells, in, [&](const std::vector<Tet>& tets, std::int32_t first) {
          return fill(old, tets, first, size_at);
        });
        if (!r) return r;
        mesh = {r->mesh.points, r->mesh.cells, boundaries_of(old, r->number), {}};
        DROGUE_TRY(check(mesh, old));
        return r;
      });
  if (!made) return made.error();
  mesh::Mesh result = to_mesh(mesh, *group);
  refill::carry_fields<3>(old_mesh, size, cells, locator, *made, result);
  return result;
}

} // namespace

mesh::NodeField sizes_of(const mesh::Mesh& mesh, std::span<const double> points) {
  const bool in_space = has_tets(mesh);
  std::vector<double> sum(points.size() / 3, 0.0), count = sum;
  const auto at = [&](std::int32_t node) {
    const double* x = points.data() + 3 * static_cast<Index>(node);
    return Point(x[0], x[1], x[2]);
  };
  for (const mesh::ElementBlock& block : mesh.blocks) {
    if (block.kind != (in_space ? mesh::ElementKind::tet4 : mesh::ElementKind::tri3)) continue;
    for (std::int32_t e = 0; e < block.count(); ++e) {
      const auto cell = block.element(e);
      const Point o = at(cell[0]), normal = (at(cell[1]) - o).cross(at(cell[2]) - o);
      // six volumes, or two areas
      const double jacobian = in_space ? std::abs(normal.dot(at(cell[3]) - o)) : normal.norm();
      for (const std::int32_t node : cell) {
        sum[static_cast<Index>(node)] += jacobian;
        count[static_cast<Index>(node)] += 1;
      }
    }
  }
  for (Index i = 0; i < sum.size(); ++i) {
    const double mean = sum[i] / std::max(count[i], 1.0);
    sum[i] = in_space ? size_of_edge * std::cbrt(std::numbers::sqrt2 * mean)
                      : std::sqrt(2 * mean / std::numbers::sqrt3);
  }
  return {1, std::move(sum)};
}

Result<mesh::Mesh> remesh(const mesh::Mesh& old) {
  return has_tets(old) ? remesh_volume(old) : remesh_plane(old);
}

Result<void> remesh_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  const auto old = mesh::read_msh(from);
  if (!old) return old.error();
  const auto made = remesh(*old);
  if (!made) return made.error();
  return mesh::write_msh(to, *made);
}

} // namespace drogue::meshing
