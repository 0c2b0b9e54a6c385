// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/pseudo_solid.hpp"

#include <cmath>

#include <Eigen/Geometry>

namespace drogue::mesh_mover {
namespace {

Eigen::Vector3d point(std::span<const double> points, std::int32_t node) noexcept {
  return Eigen::Map<const Eigen::Vector3d>(points.data() + 3 * static_cast<std::size_t>(node));
}

} // namespace

PseudoSolid pseudo_solid(double poisson_ratio, double stiffening_exponent,
                         double reference_jacobian) noexcept {
  PseudoSolid solid;
  solid.lambda = poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio));
  solid.mu = 1 / (2 * (1 + poisson_ratio));
  solid.stiffening_exponent = stiffening_exponent;
  solid.reference_jacobian = reference_jacobian;
  return solid;
}

double tet_jacobian(std::span<const double> points, std::span<const std::int32_t> nodes) noexcept {
  const Eigen::Vector3d x0 = point(points, nodes[0]);
  const Eigen::Vector3d e1 = point(points, nodes[1]) - x0;
  const Eigen::Vector3d e2 = point(points, nodes[2]) - x0;
  const Eigen::Vector3d e3 = point(points, nodes[3]) - x0;
  return e1.dot(e2.cross(e3));
}

TetGeometry tet_geometry(std::span<const double> points, std::span<const std::int32_t> nodes) noexcept {
  const Eigen::Vector3d x0 = point(points, nodes[0]);
  const Eigen::Vector3d e1 = point(points, nodes[1]) - x0;
  const Eigen::Vector3d e2 = point(points, nodes[2]) - x0;
  const Eigen::Vector3d e3 = point(points, nodes[3]) - x0;
  TetGeometry element;
  element.gradients.col(1) = e2.cross(e3);
  element.gradients.col(2) = e3.cross(e1);
  element.gradients.col(3) = e1.cross(e2);
  element.jacobian = e1.dot(element.gradients.col(1));
  element.gradients.rightCols<3>() /= element.jacobian;
  element.gradients.col(0) = -element.gradients.rightCols<3>().rowwise().sum();
  return element;
}

double stiffness_weight(const PseudoSolid& solid, double jacobian) noexcept {
  const double volume = jacobian / 6;
  if (solid.stiffening_exponent == 0) return volume;
  return volume * std::pow(solid.reference_jacobian / jacobian, solid.stiffening_exponent);
}

} // namespace drogue::mesh_mover
