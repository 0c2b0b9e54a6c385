// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/merged_surface.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "common/meshing/disjoint_sets.hpp"

namespace drogue::meshing {
namespace {

using Index = std::size_t;

/// Nodes nearer to each other than this part of the shortest edge of the boundary are at one place. The sides
/// of a membrane follow one structure and differ by rounding.
constexpr double same_place = 1e-6;

double shortest_edge(const std::vector<Point>& x, const std::vector<Triangle>& faces) {
  double square = std::numeric_limits<double>::infinity();
  for (const Triangle& t : faces)
    for (Index i = 0; i < 3; ++i)
      square = std::min(square,
                        (x[static_cast<Index>(t[i])] - x[static_cast<Index>(t[(i + 1) % 3])]).squaredNorm());
  return std::sqrt(square);
}

/// Numbers the places of the nodes on the faces, in the order of their first nodes.
void merge_nodes(const std::vector<Point>& x, MergedSurface& s) {
  std::vector<std::int32_t> nodes;
  for (const Triangle& t : s.faces) nodes.insert(nodes.end(), t.begin(), t.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  const double near = same_place * shortest_edge(x, s.faces);
  const auto at = [&](std::int32_t node) -> const Point& { return x[static_cast<Index>(node)]; };
  std::vector<std::int32_t> by_x = nodes;
  std::stable_sort(by_x.begin(), by_x.end(), [&](auto a, auto b) { return at(a).x() < at(b).x(); });
  DisjointSets places(x.size());
  for (Index i = 0; i < by_x.size(); ++i)
    for (Index j = i + 1; j < by_x.size() && at(by_x[j]).x() - at(by_x[i]).x() <= near; ++j)
      if ((at(by_x[i]) - at(by_x[j])).squaredNorm() <= near * near) places.unite(by_x[i], by_x[j]);
  s.merged.assign(x.size(), -1);
  for (const std::int32_t node : nodes) { // the representative is the smallest: it comes first
    const std::int32_t first = places.find(node);
    if (first == node) {
      s.merged[static_cast<Index>(node)] = static_cast<std::int32_t>(s.points.size());
      s.points.push_back(at(node));
    } else {
      s.merged[static_cast<Index>(node)] = s.merged[static_cast<Index>(first)];
    }
  }
}

Triangle in_merged(const MergedSurface& s, Triangle t) {
  for (std::int32_t& node : t) node = s.merged[static_cast<Index>(node)];
  return t;
}

bool same_orientation(const Triangle& a, const Triangle& b) {
  const auto i = static_cast<Index>(std::find(b.begin(), b.end(), a[0]) - b.begin());
  return b[(i + 1) % 3] == a[1];
}

std::string place(const MergedSurface& s, std::int32_t node) {
  const Point& x = s.points[static_cast<Index>(node)];
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", x.x(), x.y(), x.z());
}

/// The parts that hang together through nodes, in the order of their smallest nodes.
std::vector<std::vector<Triangle>> parts_of(const std::vector<Triangle>& triangles, Index node_count) {
  DisjointSets sets(node_count);
  for (const Triangle& t : triangles) {
    sets.unite(t[0], t[1]);
    sets.unite(t[0], t[2]);
  }
  std::map<std::int32_t, std::vector<Triangle>> parts;
  for (const Triangle& t : triangles) parts[sets.find(t[0])].push_back(t);
  std::vector<std::vector<Triangle>> result;
  for (auto& [representative, part] : parts) result.push_back(std::move(part));
  return result;
}

double enclosed_volume(const std::vector<Point>& x, const std::vector<Triangle>& surface) {
  const Point o = x[static_cast<Index>(surface.front()[0])];
  double six = 0;
  for (const Triangle& t : surface)
    six += (x[static_cast<Index>(t[0])] - o)
               .dot((x[static_cast<Index>(t[1])] - o).cross(x[static_cast<Index>(t[2])] - o));
  return six / 6;
}

struct FaceRecordOf {
  Triangle key;
  Index face = 0;
};

std::vector<FaceRecordOf> sorted_by_nodes(const MergedSurface& s) {
  std::vector<FaceRecordOf> records;
  for (Index i = 0; i < s.faces.size(); ++i) records.push_back({sorted(in_merged(s, s.faces[i])), i});
  std::sort(records.begin(), records.end(),
            [](const auto& a, const auto& b) { return a.key != b.key ? a.key < b.key : a.face < b.face; });
  return records;
}

Result<void> put_outer_first(MergedSurface& s) {
  const auto outer = [&](const std::vector<Triangle>& shell) { return enclosed_volume(s.points, shell) > 0; };
  const auto count = std::count_if(s.shells.begin(), s.shells.end(), outer);
  if (count != 1)
    return numerical_error("the volume has {} outer surfaces in place of one: it must be one region", count);
  std::stable_partition(s.shells.begin(), s.shells.end(), outer);
  for (const std::vector<Triangle>& shell : s.shells)
    if (!free_edge_loops(shell).empty())
      return numerical_error("the boundary is not closed near {}", place(s, free_edge_loops(shell)[0][0][0]));
  return {};
}

} // namespace

Result<MergedSurface> merge_sides(const TetMesh& m) {
  MergedSurface s;
  for (const NamedSurface& boundary : m.boundaries)
    s.faces.insert(s.faces.end(), boundary.triangles.begin(), boundary.triangles.end());
  merge_nodes(m.points, s);
  std::vector<Triangle> single, paired;
  std::string trouble;
  for_equal_keys(sorted_by_nodes(s), [&](auto first, auto last) {
    const Triangle t = in_merged(s, s.faces[first->face]);
    if (last - first == 1) {
      single.push_back(t);
    } else if (last - first == 2 && !same_orientation(t, in_merged(s, s.faces[(first + 1)->face]))) {
      paired.push_back(t);
    } else {
      trouble =
          fmt::format("{} faces of the boundary lie at one place near {}", last - first, place(s, t[0]));
    }
  });
  if (!trouble.empty()) return numerical_error("{}", trouble);
  if (single.empty()) return numerical_error("the volume has no outer surface");
  s.shells = parts_of(single, s.points.size());
  s.sheets = parts_of(paired, s.points.size());
  DROGUE_TRY(put_outer_first(s));
  return s;
}

namespace {

/// Tet corners joined through faces that are on no surface; the regions take the original nodes of the faces
/// they reach.
class Restorer {
 public:
  Restorer(const MergedSurface& surface, std::vector<Tet>& tets)
      : s_(surface), tets_(tets), corners_(4 * tets.size()), label_(4 * tets.size(), -1) {}

  Result<void> run() {
    const std::vector<FaceRecordOf> faces = sorted_by_nodes(s_);
    const std::vector<FaceRecord> records = sorted_faces(tets_);
    for_each_matched(faces, records, [&](auto, auto, auto first, auto last) {
      for (auto r = first + 1; r != last; ++r) join(*first, *r);
    });
    Index found = 0;
    for_each_matched(
        faces, records, [](auto, auto, auto, auto) {},
        [&](auto face, auto face_end, auto first, auto last) {
          for (; face != face_end; ++face)
            for (auto r = first; r != last; ++r) found += label(s_.faces[face->face], *r) ? 1 : 0;
        });
    if (trouble_) return *trouble_;
    if (found != s_.faces.size())
      return numerical_error("{} of {} faces of the boundary are faces of the new mesh", found,
                             s_.faces.size());
    return rename();
  }

 private:
  /// Calls `inner` for the tets' faces on no surface and `outer` for the others, with the surface's faces
  /// there.
  template <class Inner, class Outer>
  void for_each_matched(const std::vector<FaceRecordOf>& faces, const std::vector<FaceRecord>& records,
                        Inner inner, Outer outer) {
    auto next = faces.begin();
    for_equal_keys(records, [&](auto first, auto last) {
      while (next != faces.end() && next->key < first->key) ++next;
      auto end = next;
      while (end != faces.end() && end->key == first->key) ++end;
      if (end == next)
        inner(next, end, first, last);
      else
        outer(next, end, first, last);
    });
  }
  template <class Inner>
  void for_each_matched(const std::vector<FaceRecordOf>& faces, const std::vector<FaceRecord>& records,
                        Inner inner) {
    for_each_matched(faces, records, inner, [](auto, auto, auto, auto) {});
  }

  [[nodiscard]] bool on_surface(std::int32_t node) const {
    return static_cast<Index>(node) < s_.points.size();
  }
  [[nodiscard]] std::int32_t corner(std::int32_t e, std::int32_t node) const {
    const Tet& tet = tets_[static_cast<Index>(e)];
    return 4 * e + static_cast<std::int32_t>(std::find(tet.begin(), tet.end(), node) - tet.begin());
  }

  void join(const FaceRecord& a, const FaceRecord& b) {
    for (const std::int32_t node : a.key)
      if (on_surface(node)) corners_.unite(corner(a.tet, node), corner(b.tet, node));
  }

  /// Labels the regions of a tet's corners on a face that looks the same way out.
  bool label(const Triangle& face, const FaceRecord& r) {
    if (!same_orientation(in_merged(s_, face), face_of(tets_[static_cast<Index>(r.tet)], r.face)))
      return false;
    for (const std::int32_t node : face) {
      const std::int32_t merged = s_.merged[static_cast<Index>(node)];
      std::int32_t& label = label_[static_cast<Index>(corners_.find(corner(r.tet, merged)))];
      if (label >= 0 && label != node && !trouble_)
        trouble_ = numerical_error("the sides of the membrane meet near {}", place(s_, merged));
      label = node;
    }
    return true;
  }

  Result<void> rename() {
    std::vector<Tet> renamed = tets_;
    for (Index e = 0; e < tets_.size(); ++e)
      for (Index c = 0; c < 4; ++c) {
        const std::int32_t node = tets_[e][c];
        if (!on_surface(node)) continue;
        const auto i = static_cast<std::int32_t>(4 * e + c);
        renamed[e][c] = label_[static_cast<Index>(corners_.find(i))];
        if (renamed[e][c] < 0)
          return numerical_error("a tetrahedron near {} reaches no face of the boundary", place(s_, node));
      }
    tets_ = std::move(renamed);
    return {};
  }

  const MergedSurface& s_;
  std::vector<Tet>& tets_;
  DisjointSets corners_; ///< corner c of tet e is 4 e + c
  std::vector<std::int32_t> label_;
  std::optional<Error> trouble_;
};

} // namespace

Result<void> restore_sides(const MergedSurface& surface, std::vector<Tet>& tets) {
  return Restorer(surface, tets).run();
}

} // namespace drogue::meshing
