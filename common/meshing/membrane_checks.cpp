// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/membrane_checks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace drogue::meshing {
namespace {

using Index = std::size_t;
using Corners = std::array<Point, 3>;

/// Triangles closer than this, in units of the longer one's longest edge, touch.
constexpr double touching = 1e-6;

using Segment = std::array<Point, 2>;

double distance(const Point& p, const Segment& s) {
  const Point e = s[1] - s[0];
  const double length2 = e.squaredNorm();
  const double x = length2 > 0 ? std::clamp((p - s[0]).dot(e) / length2, 0.0, 1.0) : 0;
  return (p - s[0] - x * e).norm();
}

/// Infinity where the foot of the perpendicular is outside the triangle.
double distance_to_plane(const Point& p, const Corners& t) {
  const Point u = t[1] - t[0], v = t[2] - t[0], w = p - t[0];
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), det = uu * vv - uv * uv;
  const double a = (vv * u.dot(w) - uv * v.dot(w)) / det, b = (uu * v.dot(w) - uv * u.dot(w)) / det;
  if (!(a >= 0 && b >= 0 && a + b <= 1)) return std::numeric_limits<double>::infinity();
  return (w - a * u - b * v).norm();
}

double distance(const Segment& a, const Segment& b) {
  const double at_ends =
      std::min({distance(a[0], b), distance(a[1], b), distance(b[0], a), distance(b[1], a)});
  const Point u = a[1] - a[0], v = b[1] - b[0], w = a[0] - b[0];
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), det = uu * vv - uv * uv;
  if (!(det > 1e-14 * uu * vv)) return at_ends; // parallel
  const double s = (uv * v.dot(w) - vv * u.dot(w)) / det, t = (uu * v.dot(w) - uv * u.dot(w)) / det;
  if (s < 0 || s > 1 || t < 0 || t > 1) return at_ends;
  return std::min(at_ends, (w + s * u - t * v).norm());
}

bool crosses(const Segment& s, const Corners& t) {
  const Point normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const double below = normal.dot(s[0] - t[0]), above = normal.dot(s[1] - t[0]);
  if (below * above >= 0) return false;
  const Point x = s[0] + below / (below - above) * (s[1] - s[0]);
  for (Index i = 0; i < 3; ++i)
    if (normal.dot((t[(i + 1) % 3] - t[i]).cross(x - t[i])) < 0) return false;
  return true;
}

class Membrane {
 public:
  Membrane(const std::vector<Point>& points, const std::vector<Triangle>& triangles)
      : points_(points), triangles_(triangles) {}

  [[nodiscard]] Result<void> check_triangles() const {
    for (Index i = 0; i < triangles_.size(); ++i) {
      const Corners t = corners(i);
      if (!((t[1] - t[0]).cross(t[2] - t[0]).norm() > 1e-12 * longest_edge(t) * longest_edge(t)))
        return numerical_error("the membrane's {} has no area", name(i));
    }
    return {};
  }

  [[nodiscard]] Result<void> check_edges() const {
    std::map<Edge, std::array<int, 2>> edges; // how often in each direction
    for (const Triangle& t : triangles_)
      for (Index i = 0; i < 3; ++i) {
        const Edge e{t[i], t[(i + 1) % 3]};
        ++edges[sorted(e)][e[0] < e[1] ? 0 : 1];
      }
    for (const auto& [e, count] : edges) {
      if (count[0] + count[1] > 2)
        return numerical_error("{} triangles of the membrane meet in the {}; two can", count[0] + count[1],
                               name(e));
      if (count[0] > 1 || count[1] > 1)
        return numerical_error("the membrane's triangles on both sides of the {} face opposite ways",
                               name(e));
    }
    return {};
  }

  /// Every pair of triangles whose boxes overlap, by a sweep along x.
  [[nodiscard]] Result<void> check_crossings() const {
    std::vector<Eigen::AlignedBox3d> boxes(triangles_.size());
    for (Index i = 0; i < triangles_.size(); ++i)
      for (const Point& x : corners(i)) boxes[i].extend(x);
    std::vector<Index> order(triangles_.size());
    std::iota(order.begin(), order.end(), Index{0});
    std::sort(order.begin(), order.end(),
              [&](Index a, Index b) { return boxes[a].min().x() < boxes[b].min().x(); });
    for (Index k = 0; k < order.size(); ++k)
      for (Index l = k + 1; l < order.size(); ++l) {
        const Index i = std::min(order[k], order[l]), j = std::max(order[k], order[l]);
        if (boxes[order[l]].min().x() > boxes[order[k]].max().x()) break;
        if (!boxes[i].intersects(boxes[j]) || !meet(i, j)) continue;
        return numerical_error("the membrane crosses or touches itself: its {} and {}", name(i), name(j));
      }
    return {};
  }

  [[nodiscard]] std::string name(const Edge& e) const {
    return fmt::format("edge between the nodes {} and {} at {}", e[0], e[1],
                       place(0.5 * (at(e[0]) + at(e[1]))));
  }

 private:
  [[nodiscard]] const Point& at(std::int32_t node) const { return points_[static_cast<Index>(node)]; }
  [[nodiscard]] Corners corners(Index i) const {
    return {at(triangles_[i][0]), at(triangles_[i][1]), at(triangles_[i][2])};
  }
  [[nodiscard]] static double longest_edge(const Corners& t) {
    return std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
  }
  [[nodiscard]] static std::string place(const Point& x) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", x.x(), x.y(), x.z());
  }
  [[nodiscard]] std::string name(Index i) const {
    const Triangle& t = triangles_[i];
    const Corners x = corners(i);
    return fmt::format("triangle {} (nodes {}, {}, {}) at {}", i, t[0], t[1], t[2],
                       place((x[0] + x[1] + x[2]) / 3));
  }
  /// Whether an edge of either, which has no node in common with the other, comes to it. Triangles that share
  /// an edge meet there; they are folded onto each other where their other corners lie on one another.
  [[nodiscard]] bool meet(Index i, Index j) const {
    const double close = touching * std::max(longest_edge(corners(i)), longest_edge(corners(j)));
    return edges_come_to(i, j, close) || edges_come_to(j, i, close);
  }
  [[nodiscard]] bool edges_come_to(Index i, Index j, double close) const {
    const Triangle &a = triangles_[i], &b = triangles_[j];
    const auto shared = [&](std::int32_t node) { return std::find(b.begin(), b.end(), node) != b.end(); };
    const auto common = std::count_if(a.begin(), a.end(), shared);
    if (common == 3) return true; // the same triangle twice
    for (Index k = 0; k < 3; ++k) {
      const std::int32_t from = a[k], to = a[(k + 1) % 3];
      if (common == 2) {
        if (!shared(from) && segment_triangle_distance({at(from), at(from)}, corners(j)) < close) return true;
      } else if (!shared(from) && !shared(to)) {
        if (segment_triangle_distance({at(from), at(to)}, corners(j)) < close) return true;
      }
    }
    return false;
  }

  const std::vector<Point>& points_;
  const std::vector<Triangle>& triangles_;
};

} // namespace

double segment_triangle_distance(const Segment& segment, const Corners& triangle) {
  if (crosses(segment, triangle)) return 0;
  double smallest =
      std::min(distance_to_plane(segment[0], triangle), distance_to_plane(segment[1], triangle));
  for (Index i = 0; i < 3; ++i)
    smallest = std::min(smallest, distance(segment, {triangle[i], triangle[(i + 1) % 3]}));
  return smallest;
}

Result<void> check_membrane(const std::vector<Point>& points, const std::vector<Triangle>& membrane) {
  const Membrane m(points, membrane);
  DROGUE_TRY(m.check_triangles());
  DROGUE_TRY(m.check_edges());
  return m.check_crossings();
}

Result<void> check_free_edges(const std::vector<Point>& points, const std::vector<Triangle>& membrane,
                              std::size_t loops) {
  const std::vector<std::vector<Edge>> found = free_edge_loops(membrane);
  if (found.size() == loops) return {};
  const std::string which =
      found.empty()
          ? std::string("it is closed")
          : "one has the " +
                Membrane(points, membrane)
                    .name(std::min_element(found.begin(), found.end(), [](const auto& a, const auto& b) {
                            return a.size() < b.size();
                          })->front());
  return numerical_error("the free edges of the membrane form {} loops instead of {}: {}", found.size(),
                         loops, which);
}

} // namespace drogue::meshing
