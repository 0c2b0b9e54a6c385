// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/quality.hpp"

#include <cmath>
#include <limits>

#include "mesh_mover/pseudo_solid.hpp"

namespace drogue::mesh_mover {
namespace {

double sum_of_squared_edges(std::span<const double> points, std::span<const std::int32_t> nodes) noexcept {
  double sum = 0;
  for (int a = 0; a < 4; ++a)
    for (int b = a + 1; b < 4; ++b) {
      const double* p = points.data() + 3 * static_cast<std::size_t>(nodes[static_cast<std::size_t>(a)]);
      const double* q = points.data() + 3 * static_cast<std::size_t>(nodes[static_cast<std::size_t>(b)]);
      for (int i = 0; i < 3; ++i) sum += (p[i] - q[i]) * (p[i] - q[i]);
    }
  return sum;
}

double mean_ratio_from(double jacobian, double squared_edges) noexcept {
  if (!(jacobian > 0) || !(squared_edges > 0)) return 0;
  const double root = std::cbrt(jacobian / 2); // 3 V = J / 2
  return 12 * root * root / squared_edges;
}

std::array<double, 3> centroid(std::span<const double> points, std::span<const std::int32_t> nodes) noexcept {
  std::array<double, 3> c{};
  for (const std::int32_t node : nodes)
    for (std::size_t i = 0; i < 3; ++i) c[i] += points[3 * static_cast<std::size_t>(node) + i] / 4;
  return c;
}

std::span<const std::int32_t> element(std::span<const std::int32_t> tets, std::size_t e) noexcept {
  return tets.subspan(4 * e, 4);
}

} // namespace

double mean_ratio(std::span<const double> points, std::span<const std::int32_t> nodes) noexcept {
  return mean_ratio_from(tet_jacobian(points, nodes), sum_of_squared_edges(points, nodes));
}

Quality assess(std::span<const double> points, std::span<const std::int32_t> tets,
               std::span<const double> initial_jacobians) noexcept {
  Quality quality;
  quality.min_volume_ratio = std::numeric_limits<double>::infinity();
  quality.max_volume_ratio = -std::numeric_limits<double>::infinity();
  quality.worst_mean_ratio = std::numeric_limits<double>::infinity();
  double sum = 0;
  for (std::size_t e = 0; e < initial_jacobians.size(); ++e) {
    const auto nodes = element(tets, e);
    const double jacobian = tet_jacobian(points, nodes);
    const double ratio = jacobian / initial_jacobians[e];
    const double shape = mean_ratio_from(jacobian, sum_of_squared_edges(points, nodes));
    sum += shape;
    if (ratio > quality.max_volume_ratio) quality.max_volume_ratio = ratio;
    // Written so that NaN counts as the worst.
    if (!(ratio >= quality.min_volume_ratio)) {
      quality.min_volume_ratio = ratio;
      quality.min_volume_element = static_cast<std::int32_t>(e);
    }
    if (shape < quality.worst_mean_ratio) {
      quality.worst_mean_ratio = shape;
      quality.worst_element = static_cast<std::int32_t>(e);
    }
  }
  quality.mean_mean_ratio = sum / static_cast<double>(initial_jacobians.size());
  quality.min_volume_place =
      centroid(points, element(tets, static_cast<std::size_t>(quality.min_volume_element)));
  quality.worst_place = centroid(points, element(tets, static_cast<std::size_t>(quality.worst_element)));
  return quality;
}

Result<std::vector<double>> positive_jacobians(std::span<const double> points,
                                               std::span<const std::int32_t> tets) {
  std::vector<double> jacobians(tets.size() / 4);
  for (std::size_t e = 0; e < jacobians.size(); ++e) {
    jacobians[e] = tet_jacobian(points, element(tets, e));
    if (!(jacobians[e] > 0)) {
      const auto c = centroid(points, element(tets, e));
      return config_error(
          "tetrahedron {} at ({:.6g}, {:.6g}, {:.6g}) of the initial mesh has the volume {:.3g}; it "
          "must be positive",
          e, c[0], c[1], c[2], jacobians[e] / 6);
    }
  }
  return jacobians;
}

Result<void> accept(const Quality& quality, double smallest_volume_ratio) {
  const double ratio = quality.min_volume_ratio;
  if (ratio > 0 && ratio >= smallest_volume_ratio) return {};
  const auto& c = quality.min_volume_place;
  return retryable_error(
      "tetrahedron {} at ({:.6g}, {:.6g}, {:.6g}) {}: its volume would be {:.3g} of the initial "
      "one (smallest allowed: {:.3g}); try a smaller step",
      quality.min_volume_element, c[0], c[1], c[2], ratio > 0 ? "collapses" : "is inverted", ratio,
      smallest_volume_ratio);
}

} // namespace drogue::mesh_mover
