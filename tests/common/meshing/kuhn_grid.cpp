// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/common/meshing/kuhn_grid.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <Eigen/Geometry>

namespace drogue::meshing {
namespace {

const Point& at(const TetMesh& m, std::int32_t node) {
  return m.points[static_cast<std::size_t>(node)];
}

Point centre(const TetMesh& m, const Triangle& t) {
  return (at(m, t[0]) + at(m, t[1]) + at(m, t[2])) / 3;
}

Point normal(const TetMesh& m, const Triangle& t) {
  return (at(m, t[1]) - at(m, t[0])).cross(at(m, t[2]) - at(m, t[0])).normalized();
}

void name_boundaries(TetMesh& m) {
  m.boundaries = {{"inflow", {}}, {"outflow", {}}, {"side", {}}};
  for_equal_keys(sorted_faces(m.tets), [&](auto first, auto last) {
    if (last - first != 1) return;
    const Triangle t = face_of(m.tets[static_cast<std::size_t>(first->tet)], first->face);
    const double nz = normal(m, t).z();
    m.boundaries[nz < -0.5 ? 0 : nz > 0.5 ? 1 : 2].triangles.push_back(t);
  });
}

} // namespace

TetMesh kuhn_grid(int nx, int ny, int nz) {
  TetMesh m;
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) m.points.emplace_back(i, j, k);
  const auto node = [&](const std::array<int, 3>& p) { return p[0] + (nx + 1) * (p[1] + (ny + 1) * p[2]); };
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        std::array<std::size_t, 3> axes{0, 1, 2};
        do {
          std::array<int, 3> p{i, j, k};
          Tet tet{node(p)};
          for (std::size_t step = 0; step < 3; ++step) {
            ++p[axes[step]];
            tet[step + 1] = node(p);
          }
          m.tets.push_back(tet);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
  orient(m);
  name_boundaries(m);
  return m;
}

std::vector<Triangle> grid_faces(const TetMesh& grid, int axis,
                                 const std::function<bool(const Point&)>& selected) {
  std::vector<Triangle> faces;
  for_equal_keys(sorted_faces(grid.tets), [&](auto first, auto) {
    Triangle t = face_of(grid.tets[static_cast<std::size_t>(first->tet)], first->face);
    const double along = normal(grid, t)[axis];
    if (std::abs(along) < 0.99 || !selected(centre(grid, t))) return;
    if (along < 0) std::swap(t[1], t[2]);
    faces.push_back(t);
  });
  return faces;
}

std::vector<Triangle> without_corners(std::vector<Triangle> surface) {
  std::set<std::int32_t> free;
  for (const auto& loop : free_edge_loops(surface))
    for (const Edge& e : loop) free.insert(e.begin(), e.end());
  const auto corner = [&](const Triangle& t) {
    return std::all_of(t.begin(), t.end(), [&](std::int32_t node) { return free.count(node) > 0; });
  };
  surface.erase(std::remove_if(surface.begin(), surface.end(), corner), surface.end());
  return surface;
}

} // namespace drogue::meshing
