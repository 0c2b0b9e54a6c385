// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/drag_assembly.hpp"

#include <algorithm>

#include "structure_solver/elements/drag.hpp"

namespace drogue::structure {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The step of the central difference that gives the gradient of the wind, relative to the size of the mesh.
constexpr double relative_difference = 1e-5;

Vector3d air(const DragLoad& load, const Vector3d& x, double t) {
  Vector3d v = Vector3d::Zero();
  for (std::size_t c = 0; c < 3; ++c)
    if (!load.air_velocity[c].is_zero()) v(static_cast<int>(c)) = load.air_velocity[c](x(0), x(1), x(2), t);
  return v;
}

Matrix3d air_gradient(const DragLoad& load, const Vector3d& x, double t, double h) {
  Matrix3d G = Matrix3d::Zero();
  if (std::all_of(load.air_velocity.begin(), load.air_velocity.end(),
                  [](const auto& v) { return v.is_zero(); }))
    return G;
  for (int c = 0; c < 3; ++c) {
    const Vector3d step = h * Vector3d::Unit(c);
    G.col(c) = (air(load, x + step, t) - air(load, x - step, t)) / (2 * h);
  }
  return G;
}

double size_of(const mesh::Mesh& mesh) {
  const Eigen::Map<const Eigen::Matrix3Xd> X(mesh.points.data(), 3, mesh.node_count());
  const double size = (X.rowwise().maxCoeff() - X.rowwise().minCoeff()).maxCoeff();
  return size > 0 ? size : 1;
}

class DragSum {
 public:
  DragSum(const Model& model, const DragRequest& request, std::span<double> residual)
      : model_(model),
        request_(request),
        residual_(residual),
        difference_(request.by_position ? relative_difference * size_of(model.mesh) : 0) {}

  void point(const DragLoad& load, std::int32_t node) {
    const Vector3d x = position(node);
    const PointDrag drag =
        PointDrag::at(request_.factor * load.k, air(load, x, request_.time) - at(request_.velocity, node));
    subtract(node, drag.force);
    if (!request_.tangent) return;
    Matrix3d K = request_.velocity_scale * drag.by_wind;
    if (request_.by_position)
      K -= request_.displacement_scale * drag.by_wind * air_gradient(load, x, request_.time, difference_);
    request_.tangent->add_block(node, node, K);
  }

  void line(const DragLoad& load, std::int32_t n1, std::int32_t n2) {
    const Vector3d x1 = position(n1), x2 = position(n2), middle = 0.5 * (x1 + x2);
    const Vector3d w =
        air(load, middle, request_.time) - 0.5 * (at(request_.velocity, n1) + at(request_.velocity, n2));
    const LineDrag drag = LineDrag::at(request_.factor * load.k, load.cross_flow, x2 - x1, w);
    subtract(n1, 0.5 * drag.force);
    subtract(n2, 0.5 * drag.force);
    if (!request_.tangent) return;
    // each node takes half of the force and gives half of the velocity and of the middle
    Matrix3d to_both = 0.25 * request_.velocity_scale * drag.by_wind, by_line = Matrix3d::Zero();
    if (request_.by_position) {
      const double s = request_.displacement_scale;
      to_both -= 0.25 * s * drag.by_wind * air_gradient(load, middle, request_.time, difference_);
      by_line = 0.5 * s * drag.by_line;
    }
    for (const std::int32_t row : {n1, n2}) {
      request_.tangent->add_block(row, n1, to_both + by_line);
      request_.tangent->add_block(row, n2, to_both - by_line);
    }
  }

 private:
  [[nodiscard]] static Vector3d at(std::span<const double> values, std::int32_t node) {
    return Eigen::Map<const Vector3d>(&values[3 * static_cast<std::size_t>(node)]);
  }
  [[nodiscard]] Vector3d position(std::int32_t node) const {
    return at(model_.mesh.points, node) + at(request_.displacement, node);
  }
  void subtract(std::int32_t node, const Vector3d& force) {
    for (std::size_t c = 0; c < 3; ++c)
      residual_[3 * static_cast<std::size_t>(node) + c] -= force(static_cast<int>(c));
  }

  const Model& model_;
  const DragRequest& request_;
  std::span<double> residual_;
  double difference_;
};

} // namespace

void add_drag(const Model& model, const DragRequest& request, std::span<double> residual) {
  if (model.drag.empty()) return;
  DragSum sum(model, request, residual);
  for (const DragLoad& load : model.drag)
    for (std::size_t k = 0; k < load.nodes.size(); k += static_cast<std::size_t>(load.nodes_per_element)) {
      if (load.nodes_per_element == 1)
        sum.point(load, load.nodes[k]);
      else
        sum.line(load, load.nodes[k], load.nodes[k + 1]);
    }
}

} // namespace drogue::structure
