// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/node_doubling.hpp"

#include <algorithm>
#include <utility>

#include "common/meshing/disjoint_sets.hpp"

namespace drogue::meshing {
namespace {

using Index = std::size_t;
constexpr int upper_side = 0;
constexpr int lower_side = 1;

struct SurfaceRecord {
  Triangle key;
  std::int32_t triangle = 0;
};

std::vector<SurfaceRecord> sorted_surface(const std::vector<Triangle>& triangles) {
  std::vector<SurfaceRecord> records;
  for (Index i = 0; i < triangles.size(); ++i)
    records.push_back({sorted(triangles[i]), static_cast<std::int32_t>(i)});
  std::sort(records.begin(), records.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
  return records;
}

/// A face of a tet; tet < 0: none.
struct TetFace {
  std::int32_t tet = -1;
  std::int32_t face = 0;
};

bool same_orientation(const Triangle& a, const Triangle& b) {
  const auto i = static_cast<Index>(std::find(b.begin(), b.end(), a[0]) - b.begin());
  return b[(i + 1) % 3] == a[1];
}

std::int32_t corner(const Tet& tet, std::int32_t node) {
  return static_cast<std::int32_t>(std::find(tet.begin(), tet.end(), node) - tet.begin());
}

/// The work of double_nodes: regions of tet corners around the nodes of the surface.
class Cut {
 public:
  explicit Cut(TetMesh& m)
      : m_(m),
        corners_(4 * m.tets.size()),
        sides_(m.interior.size()),
        on_surface_(m.points.size(), false),
        corner_side_(4 * m.tets.size(), 0) {
    for (const Triangle& t : m.interior)
      for (const std::int32_t node : t) on_surface_[static_cast<Index>(node)] = true;
  }

  /// Joins tet corners across faces and notes which tets lie on which side of each surface triangle.
  void join();
  Result<void> check_sides();
  Result<DoublingSummary> renumber();
  [[nodiscard]] std::vector<Triangle> side_triangles(int side) const;

 private:
  [[nodiscard]] const Tet& tet(std::int32_t e) const { return m_.tets[static_cast<Index>(e)]; }
  void join_corners(const FaceRecord& a, const FaceRecord& b);
  void note_side(std::int32_t triangle, const FaceRecord& record);

  TetMesh& m_;
  DisjointSets corners_; ///< corner c of tet e is 4 e + c
  std::vector<std::array<TetFace, 2>> sides_;
  std::vector<bool> on_surface_;
  std::vector<char> corner_side_; ///< of a region's representative: bit 0 upper, bit 1 lower
  int overlapping_ = 0;
};

void Cut::join_corners(const FaceRecord& a, const FaceRecord& b) {
  for (const std::int32_t node : a.key)
    if (on_surface_[static_cast<Index>(node)])
      corners_.unite(4 * a.tet + corner(tet(a.tet), node), 4 * b.tet + corner(tet(b.tet), node));
}

void Cut::note_side(std::int32_t triangle, const FaceRecord& record) {
  // The outward normal of a tet below the surface is the surface's normal.
  const bool below =
      same_orientation(m_.interior[static_cast<Index>(triangle)], face_of(tet(record.tet), record.face));
  TetFace& side = sides_[static_cast<Index>(triangle)][below ? lower_side : upper_side];
  if (side.tet >= 0) ++overlapping_;
  side = {record.tet, record.face};
}

void Cut::join() {
  const std::vector<SurfaceRecord> surface = sorted_surface(m_.interior);
  auto next = surface.begin();
  for_equal_keys(sorted_faces(m_.tets), [&](auto first, auto last) {
    while (next != surface.end() && next->key < first->key) ++next;
    if (next != surface.end() && next->key == first->key) {
      for (auto record = first; record != last; ++record) note_side(next->triangle, *record);
    } else {
      for (auto record = first + 1; record != last; ++record) join_corners(*first, *record);
    }
  });
}

Result<void> Cut::check_sides() {
  std::int32_t missing = 0;
  for (const auto& side : sides_) missing += side[upper_side].tet < 0 || side[lower_side].tet < 0;
  if (missing > 0 || overlapping_ > 0)
    return numerical_error(
        "{} of {} triangles of the interior surface do not have a tetrahedron on each side",
        missing + overlapping_, sides_.size());
  for (const auto& side : sides_)
    for (const int s : {upper_side, lower_side}) {
      const TetFace& f = side[static_cast<Index>(s)];
      for (const std::int32_t node : face_of(tet(f.tet), f.face))
        corner_side_[static_cast<Index>(corners_.find(4 * f.tet + corner(tet(f.tet), node)))] |=
            static_cast<char>(1 << s);
    }
  return {};
}

Result<DoublingSummary> Cut::renumber() {
  const NodeTets node_tets(m_.points.size(), m_.tets);
  std::vector<Tet> tets = m_.tets;
  std::vector<bool> doubled(on_surface_.size(), false);
  DoublingSummary summary;
  for (Index i = 0; i < on_surface_.size(); ++i) summary.origin.push_back(static_cast<std::int32_t>(i));
  for (Index i = 0; i < on_surface_.size(); ++i) {
    if (!on_surface_[i]) continue;
    const auto node = static_cast<std::int32_t>(i);
    std::vector<std::int32_t> regions;
    for (const std::int32_t e : node_tets.of(node))
      regions.push_back(corners_.find(4 * e + corner(tet(e), node)));
    std::vector<std::int32_t> distinct = regions;
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    if (distinct.size() == 1) {
      ++summary.single_nodes;
      continue;
    }
    const auto side_of = [&](std::int32_t region) { return corner_side_[static_cast<Index>(region)]; };
    if (distinct.size() != 2 || side_of(distinct[0]) + side_of(distinct[1]) != 3 ||
        side_of(distinct[0]) % 3 == 0)
      return numerical_error("the interior surface separates {} regions around its node at ({:.6g}, {:.6g}, "
                             "{:.6g}) instead of an upper and a lower one",
                             distinct.size(), m_.points[i].x(), m_.points[i].y(), m_.points[i].z());
    ++summary.doubled_nodes;
    doubled[i] = true;
    const auto copy = static_cast<std::int32_t>(m_.points.size());
    m_.points.push_back(Point(m_.points[i]));
    summary.origin.push_back(node);
    for (Index k = 0; k < regions.size(); ++k) {
      const std::int32_t e = node_tets.of(node)[k];
      if (side_of(regions[k]) == 1 << upper_side)
        tets[static_cast<Index>(e)][static_cast<Index>(corner(tet(e), node))] = copy;
    }
  }
  const auto uncut = std::count_if(m_.interior.begin(), m_.interior.end(), [&](const Triangle& t) {
    return std::none_of(t.begin(), t.end(), [&](auto node) { return doubled[static_cast<Index>(node)]; });
  });
  if (uncut > 0)
    return numerical_error(
        "{} triangles of the interior surface have all their nodes on its free edges and cannot "
        "be cut open",
        uncut);
  m_.tets = std::move(tets);
  return summary;
}

std::vector<Triangle> Cut::side_triangles(int side) const {
  std::vector<Triangle> triangles;
  for (const auto& s : sides_) {
    const TetFace& f = s[static_cast<Index>(side)];
    triangles.push_back(face_of(tet(f.tet), f.face));
  }
  return triangles;
}

} // namespace

Result<DoublingSummary> double_nodes(TetMesh& m, const std::string& upper, const std::string& lower) {
  Cut cut(m);
  cut.join();
  DROGUE_TRY(cut.check_sides());
  Result<DoublingSummary> summary = cut.renumber();
  if (!summary) return summary;
  m.boundaries.push_back({upper, cut.side_triangles(upper_side)});
  m.boundaries.push_back({lower, cut.side_triangles(lower_side)});
  m.interior.clear();
  return summary;
}

} // namespace drogue::meshing
