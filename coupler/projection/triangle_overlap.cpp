// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/triangle_overlap.hpp"

#include <algorithm>
#include <cmath>

namespace drogue::projection {
namespace {

/// A corner of the polygon in the parent coordinates of the first triangle, and its height above that one's
/// plane.
struct Corner {
  double xi = 0, eta = 0, height = 0;
};
struct Polygon {
  std::array<Corner, 7> corner; ///< a triangle cut by three lines has at most six
  int count = 0;
  void add(const Corner& c) { corner[static_cast<std::size_t>(count++)] = c; }
};

/// Keeps the part where distance(c) >= 0 [sutherland1974].
template <class Distance>
Polygon clip(const Polygon& p, const Distance& distance) {
  Polygon kept;
  for (int i = 0; i < p.count; ++i) {
    const Corner &a = p.corner[static_cast<std::size_t>(i)],
                 &b = p.corner[static_cast<std::size_t>(i + 1 == p.count ? 0 : i + 1)];
    const double da = distance(a), db = distance(b);
    if (da >= 0) kept.add(a);
    if ((da >= 0) == (db >= 0)) continue;
    const double t = da / (da - db); // the two have different signs
    kept.add({a.xi + t * (b.xi - a.xi), a.eta + t * (b.eta - a.eta), a.height + t * (b.height - a.height)});
  }
  return kept;
}

/// int (1, xi, eta) (1, xi, eta)^T over the polygon, fan by fan; positive when it goes round
/// counterclockwise.
Eigen::Matrix3d moments(const Polygon& p) {
  Eigen::Matrix3d Q = Eigen::Matrix3d::Zero();
  const Corner& o = p.corner[0];
  for (std::size_t i = 1; i + 1 < static_cast<std::size_t>(p.count); ++i) {
    const Corner &a = p.corner[i], &b = p.corner[i + 1];
    const double area = 0.5 * ((a.xi - o.xi) * (b.eta - o.eta) - (b.xi - o.xi) * (a.eta - o.eta));
    const double x = o.xi + a.xi + b.xi, y = o.eta + a.eta + b.eta;
    Q(0, 0) += area;
    Q(0, 1) += area / 3 * x;
    Q(0, 2) += area / 3 * y;
    Q(1, 1) += area / 12 * (o.xi * o.xi + a.xi * a.xi + b.xi * b.xi + x * x);
    Q(1, 2) += area / 12 * (o.xi * o.eta + a.xi * a.eta + b.xi * b.eta + x * y);
    Q(2, 2) += area / 12 * (o.eta * o.eta + a.eta * a.eta + b.eta * b.eta + y * y);
  }
  Q(1, 0) = Q(0, 1);
  Q(2, 0) = Q(0, 2);
  Q(2, 1) = Q(1, 2);
  return Q;
}

/// Row a: coefficients of N_a of the triangle s in (1, xi, eta); they add up to (1, 0, 0). `det`: twice its
/// area.
Eigen::Matrix3d shape_coefficients(const std::array<Corner, 3>& s, double det) {
  Eigen::Matrix3d N;
  const double g1 = (s[2].eta - s[0].eta) / det, h1 = -(s[2].xi - s[0].xi) / det;
  const double g2 = -(s[1].eta - s[0].eta) / det, h2 = (s[1].xi - s[0].xi) / det;
  N.row(1) << -g1 * s[0].xi - h1 * s[0].eta, g1, h1;
  N.row(2) << -g2 * s[0].xi - h2 * s[0].eta, g2, h2;
  N.row(0) = Eigen::RowVector3d(1, 0, 0) - N.row(1) - N.row(2);
  return N;
}

} // namespace

TriangleFrame::TriangleFrame(const Triangle& X) noexcept : origin_(X[0]) {
  const Eigen::Vector3d g = X[1] - X[0], h = X[2] - X[0], n = g.cross(h);
  jacobian_ = n.norm();
  normal_ = n / jacobian_;
  dual_xi_ = h.cross(normal_) / jacobian_;
  dual_eta_ = normal_.cross(g) / jacobian_;
}

Overlap TriangleFrame::overlap(const Triangle& other) const noexcept {
  Overlap result;
  std::array<Corner, 3> s;
  Polygon p;
  for (std::size_t a = 0; a < 3; ++a) {
    const Eigen::Vector3d r = other[a] - origin_;
    s[a] = {dual_xi_.dot(r), dual_eta_.dot(r), normal_.dot(r)};
    p.add(s[a]);
  }
  const auto beyond = [&s](const auto& distance) {
    return distance(s[0]) <= 0 && distance(s[1]) <= 0 && distance(s[2]) <= 0;
  };
  const auto left = [](const Corner& c) { return c.xi; };
  const auto lower = [](const Corner& c) { return c.eta; };
  const auto diagonal = [](const Corner& c) { return 1 - c.xi - c.eta; };
  const double det =
      (s[1].xi - s[0].xi) * (s[2].eta - s[0].eta) - (s[2].xi - s[0].xi) * (s[1].eta - s[0].eta);
  const double edges = (other[1] - other[0]).squaredNorm() + (other[2] - other[0]).squaredNorm();
  if (!(std::abs(det) * jacobian_ > 1e-6 * edges)) return result; // on edge, or without area
  result.sense = det > 0 ? 1 : -1;
  if (beyond(left) || beyond(lower) || beyond(diagonal)) return result;
  p = clip(clip(clip(p, left), lower), diagonal);
  if (p.count < 3) return result;
  const Eigen::Matrix3d Q = result.sense * moments(p);
  if (!(Q(0, 0) > 0)) return result;
  result.corners = p.count;
  result.area = Q(0, 0);
  for (std::size_t i = 0; i < static_cast<std::size_t>(p.count); ++i) {
    if (std::abs(p.corner[i].height) < result.gap) continue;
    result.gap = std::abs(p.corner[i].height);
    result.gap_at = {p.corner[i].xi, p.corner[i].eta};
  }
  const Eigen::Matrix3d N = shape_coefficients(s, det), NQ = N * Q;
  result.cross.col(1) = NQ.col(1);
  result.cross.col(2) = NQ.col(2);
  result.cross.col(0) = NQ.col(0) - NQ.col(1) - NQ.col(2);
  result.own = NQ * N.transpose();
  return result;
}

} // namespace drogue::projection
