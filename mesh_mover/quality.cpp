// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/quality.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "mesh_mover/pseudo_solid.hpp"

namespace drogue::mesh_mover {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double degrees = 180 / std::numbers::pi;

double length_power(int dimension, double squared_length) noexcept {
  return dimension == 2 ? squared_length : squared_length * std::sqrt(squared_length);
}

double mean_ratio_of(int dimension, double jacobian, double squared_edges) noexcept {
  if (dimension == 2) return 2 * std::numbers::sqrt3 * jacobian / squared_edges; // A = J / 2
  const double root = std::cbrt(jacobian / 2);                                   // 3 V = J / 2
  return 12 * root * root / squared_edges;
}

/// The faces opposite the nodes a and b have the normals -grad N_a and -grad N_b.
template <int D>
double largest_cosine(const Eigen::Matrix<double, D, D>& edges) noexcept {
  Eigen::Matrix<double, D, D + 1> normals;
  normals.template rightCols<D>() = edges.inverse().transpose();
  normals.col(0) = -normals.template rightCols<D>().rowwise().sum();
  for (int a = 0; a <= D; ++a) normals.col(a) /= std::sqrt(normals.col(a).squaredNorm());
  double largest = -1;
  for (int a = 0; a <= D; ++a)
    for (int b = a + 1; b <= D; ++b) largest = std::max(largest, -normals.col(a).dot(normals.col(b)));
  return largest;
}

template <int D>
CellShape shape_of(std::span<const double> points, std::span<const std::int32_t> nodes) noexcept {
  const auto edges = simplex_edges<D>(points, nodes);
  double longest = 0;
  double sum = 0;
  const auto add = [&](const auto& edge) {
    const double squared = edge.squaredNorm();
    longest = std::max(longest, squared);
    sum += squared;
  };
  for (int a = 0; a < D; ++a) {
    add(edges.col(a));
    for (int b = 0; b < a; ++b) add(edges.col(a) - edges.col(b));
  }
  CellShape shape{edges.determinant(), infinity, 0, 1};
  if (!(shape.jacobian > 0)) return shape;
  shape.aspect = length_power(D, longest) / shape.jacobian;
  shape.mean_ratio = mean_ratio_of(D, shape.jacobian, sum);
  shape.cosine = largest_cosine<D>(edges);
  return shape;
}

double angle_of(double cosine) noexcept {
  return degrees * std::acos(std::clamp(cosine, -1.0, 1.0));
}

/// Largest |log2| of values between `low` and `high`.
double largest_log(double low, double high) noexcept {
  if (!(low > 0) || !std::isfinite(high)) return infinity;
  return std::max(std::abs(std::log2(low)), std::abs(std::log2(high)));
}

template <int D>
Quality assess_cells(std::span<const double> points, const Cells& cells,
                     const InitialShapes& initial) noexcept {
  Quality q;
  q.min_volume_ratio = infinity;
  q.max_volume_ratio = -infinity;
  q.worst_mean_ratio = infinity;
  double min_aspect = infinity, max_aspect = 0, worst_aspect = 0, cosine = -1, sum = 0;
  for (std::size_t e = 0; e < cells.count(); ++e) {
    const CellShape shape = shape_of<D>(points, cells.cell(e));
    const auto index = static_cast<std::int32_t>(e);
    const double ratio = shape.jacobian / initial.jacobians[e];
    sum += shape.mean_ratio;
    cosine = std::max(cosine, shape.cosine);
    if (ratio > q.max_volume_ratio) q.max_volume_ratio = ratio;
    // Written so that NaN counts as the worst.
    if (!(ratio >= q.min_volume_ratio)) {
      q.min_volume_ratio = ratio;
      q.min_volume_element = index;
    }
    if (shape.mean_ratio < q.worst_mean_ratio) {
      q.worst_mean_ratio = shape.mean_ratio;
      q.worst_element = index;
    }
    const double aspect = shape.aspect / initial.aspects[e];
    min_aspect = std::min(min_aspect, aspect);
    max_aspect = std::max(max_aspect, aspect);
    if (const double change = std::max(aspect, 1 / aspect); change > worst_aspect) {
      worst_aspect = change;
      q.f_AR_element = index;
    }
  }
  q.f_A = largest_log(q.min_volume_ratio, q.max_volume_ratio);
  q.f_AR = largest_log(min_aspect, max_aspect);
  q.mean_mean_ratio = sum / static_cast<double>(cells.count());
  q.smallest_angle = angle_of(cosine);
  return q;
}

Percentiles percentiles(std::vector<double>& values) {
  const auto value_at = [&](double fraction) {
    const auto k =
        values.begin() + static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), k, values.end());
    return *k;
  };
  return {value_at(0.01), value_at(0.1), value_at(0.5)};
}

Result<void> check_nodes(std::span<const double> points, const Cells& cells) {
  std::vector<bool> used(points.size() / 3, false);
  for (const std::int32_t node : cells.nodes) used[static_cast<std::size_t>(node)] = true;
  const auto orphan = static_cast<std::size_t>(std::find(used.begin(), used.end(), false) - used.begin());
  if (orphan == used.size()) return {};
  return config_error("node {} at ({:.6g}, {:.6g}, {:.6g}) of the initial mesh belongs to no {}", orphan,
                      points[3 * orphan], points[3 * orphan + 1], points[3 * orphan + 2], cells.name());
}

std::string at_cell(const Cells& cells, std::int32_t e, std::span<const double> points) {
  const auto c = centroid(points, cells.cell(static_cast<std::size_t>(e)));
  return fmt::format("{} {} at ({:.6g}, {:.6g}, {:.6g})", cells.name(), e, c[0], c[1], c[2]);
}

} // namespace

CellShape cell_shape(int dimension, std::span<const double> points,
                     std::span<const std::int32_t> nodes) noexcept {
  return with_dimension(dimension, [&](auto d) { return shape_of<d>(points, nodes); });
}

Quality assess(std::span<const double> points, const Cells& cells, const InitialShapes& initial) noexcept {
  Quality quality =
      with_dimension(cells.dimension, [&](auto d) { return assess_cells<d>(points, cells, initial); });
  quality.min_volume_place =
      centroid(points, cells.cell(static_cast<std::size_t>(quality.min_volume_element)));
  quality.worst_place = centroid(points, cells.cell(static_cast<std::size_t>(quality.worst_element)));
  return quality;
}

Result<InitialShapes> initial_shapes(std::span<const double> points, const Cells& cells) {
  if (cells.count() == 0)
    return config_error("the mesh has neither tetrahedra nor triangles in one plane z = const");
  DROGUE_TRY(check_nodes(points, cells));
  InitialShapes shapes;
  for (std::size_t e = 0; e < cells.count(); ++e) {
    const CellShape shape = cell_shape(cells.dimension, points, cells.cell(e));
    if (!(shape.jacobian > 0))
      return config_error("{} of the initial mesh has the {} {:.3g}; it must be positive",
                          at_cell(cells, static_cast<std::int32_t>(e), points),
                          cells.dimension == 2 ? "area" : "volume",
                          shape.jacobian / (cells.dimension == 2 ? 2 : 6));
    shapes.jacobians.push_back(shape.jacobian);
    shapes.aspects.push_back(shape.aspect);
  }
  return shapes;
}

Distribution distribution(std::span<const double> points, const Cells& cells) {
  std::vector<double> mean_ratio(cells.count());
  std::vector<double> angle(cells.count());
  for (std::size_t e = 0; e < cells.count(); ++e) {
    const CellShape shape = cell_shape(cells.dimension, points, cells.cell(e));
    mean_ratio[e] = shape.mean_ratio;
    angle[e] = -shape.cosine; // grows with the angle
  }
  Distribution result{percentiles(mean_ratio), percentiles(angle)};
  for (double* value : {&result.angle.p1, &result.angle.p10, &result.angle.p50}) *value = angle_of(-*value);
  return result;
}

std::string broken_limit(const Quality& q, const Limits& limits, const Cells& cells,
                         std::span<const double> points) {
  if (!(q.min_volume_ratio > 0) || q.min_volume_ratio < limits.min_volume_ratio)
    return fmt::format("{} {}: its volume would be {:.3g} of the initial one (smallest allowed: {:.3g})",
                       at_cell(cells, q.min_volume_element, points),
                       q.min_volume_ratio > 0 ? "collapses" : "is inverted", q.min_volume_ratio,
                       limits.min_volume_ratio);
  if (q.worst_mean_ratio < limits.mean_ratio)
    return fmt::format("{} is distorted: its mean ratio would be {:.3g} (smallest allowed: {:.3g})",
                       at_cell(cells, q.worst_element, points), q.worst_mean_ratio, limits.mean_ratio);
  if (q.smallest_angle < limits.angle)
    return fmt::format("{} is among those distorted: the smallest angle of the mesh would be {:.3g} degrees "
                       "(smallest allowed: {:.3g})",
                       at_cell(cells, q.worst_element, points), q.smallest_angle, limits.angle);
  if (q.f_A > limits.f_A)
    return fmt::format("f_A, the largest |log2| of an element's change of volume, would be {:.3g} (largest "
                       "allowed: {:.3g}); the smallest ratio of volumes is that of {}",
                       q.f_A, limits.f_A, at_cell(cells, q.min_volume_element, points));
  if (q.f_AR > limits.f_AR)
    return fmt::format("{} changes its aspect ratio: f_AR would be {:.3g} (largest allowed: {:.3g})",
                       at_cell(cells, q.f_AR_element, points), q.f_AR, limits.f_AR);
  return {};
}

} // namespace drogue::mesh_mover
