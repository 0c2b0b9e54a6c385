// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/element.hpp"

#include <algorithm>
#include <cmath>

namespace drogue::projection {

using mesh::ElementKind;

namespace {

bool is_line(ElementKind kind) {
  return mesh::dimension(kind) == 1;
}

double parent_area(ElementKind kind) {
  if (is_line(kind)) return 2;
  return fem::is_quadrilateral(kind) ? 4 : 0.5;
}

} // namespace

ElementShape element_shape(ElementKind kind, double xi, double eta) noexcept {
  if (!is_line(kind)) return {fem::surface_shape(kind, xi, eta), 0};
  const fem::LineShape line = fem::line_shape(kind, xi);
  ElementShape s{{}, 1};
  s.nodes = line.nodes;
  std::copy(line.N.begin(), line.N.end(), s.N.begin());
  std::copy(line.dN_dxi.begin(), line.dN_dxi.end(), s.dN_dxi.begin());
  return s;
}

std::vector<fem::SurfacePoint> element_quadrature(ElementKind kind, int degree) {
  if (!is_line(kind)) return fem::surface_quadrature(kind, degree);
  const fem::GaussRule gauss = fem::gauss_legendre(degree / 2 + 1);
  std::vector<fem::SurfacePoint> rule;
  for (std::size_t i = 0; i < gauss.points.size(); ++i)
    rule.push_back({gauss.points[i], 0, gauss.weights[i]});
  return rule;
}

std::vector<fem::SurfacePoint> composite_quadrature(ElementKind kind, int degree, int n) {
  const auto base = element_quadrature(kind, degree);
  const double h = 1.0 / n;
  std::vector<fem::SurfacePoint> rule;
  if (is_line(kind)) {
    for (int i = 0; i < n; ++i)
      for (const fem::SurfacePoint& q : base) rule.push_back({(2 * i + 1 + q.xi) * h - 1, 0, q.weight * h});
    return rule;
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (const fem::SurfacePoint& q : base) {
        if (fem::is_quadrilateral(kind)) {
          rule.push_back({(2 * i + 1 + q.xi) * h - 1, (2 * j + 1 + q.eta) * h - 1, q.weight * h * h});
          continue;
        }
        if (i + j < n) rule.push_back({(i + q.xi) * h, (j + q.eta) * h, q.weight * h * h});
        if (i + j + 1 < n) rule.push_back({(i + 1 - q.xi) * h, (j + 1 - q.eta) * h, q.weight * h * h});
      }
    }
  }
  return rule;
}

std::array<double, 2> parent_centre(ElementKind kind) noexcept {
  return is_line(kind) ? std::array{0.0, 0.0} : fem::parent_centre(kind);
}

NodeMatrix gather(std::span<const std::int32_t> nodes, std::span<const double> coordinates) noexcept {
  NodeMatrix X = NodeMatrix::Zero();
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    const double* x = coordinates.data() + 3 * static_cast<std::size_t>(nodes[a]);
    X.col(static_cast<Eigen::Index>(a)) << x[0], x[1], x[2];
  }
  return X;
}

const Eigen::Matrix3d& flat_mass(ElementKind kind) noexcept {
  static const Eigen::Matrix3d triangle = (Eigen::Matrix3d() << 2, 1, 1, 1, 2, 1, 1, 1, 2).finished() / 24;
  static const Eigen::Matrix3d line = (Eigen::Matrix3d() << 2, 1, 0, 1, 2, 0, 0, 0, 0).finished() / 3;
  return kind == ElementKind::line2 ? line : triangle;
}

double rough_area(ElementKind kind, const NodeMatrix& X) noexcept {
  const auto centre = parent_centre(kind);
  return parent_area(kind) * area_vector(element_shape(kind, centre[0], centre[1]), X).norm();
}

double longest_edge(ElementKind kind, const NodeMatrix& X) noexcept {
  if (is_line(kind)) return (X.col(1) - X.col(0)).norm();
  const int corners = fem::is_quadrilateral(kind) ? 4 : 3;
  double longest = 0;
  for (int c = 0; c < corners; ++c) longest = std::max(longest, (X.col(c) - X.col((c + 1) % corners)).norm());
  return longest;
}

double node_spacing(ElementKind kind, const NodeMatrix& X) noexcept {
  const double area = rough_area(kind, X);
  switch (kind) {
  case ElementKind::line2:
    return area;
  case ElementKind::line3:
    return 0.5 * area;
  case ElementKind::tri6:
    return 0.5 * std::sqrt(2 * area);
  case ElementKind::quad4:
    return std::sqrt(area);
  case ElementKind::quad9:
    return 0.5 * std::sqrt(area);
  case ElementKind::tri3:
  case ElementKind::point1:
  case ElementKind::tet4:
  case ElementKind::tet10:
  case ElementKind::hex27:
    break;
  }
  return std::sqrt(2 * area);
}

} // namespace drogue::projection
