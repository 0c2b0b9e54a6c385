// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/quality.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/base/worker_pool.hpp"
#include "common/la_krylov/session.hpp"
#include "mesh_mover/pseudo_solid.hpp"

namespace drogue::mesh_mover {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double degrees = 180 / std::numbers::pi;

/// What the shape of a cell is compared by, without roots: they are taken of the extremes alone.
struct Measures {
  double jacobian = 0;
  double squared_aspect = infinity;
  double squared_edges = 0; ///< their sum
  double signed_squared_cosine = 1;
};

double mean_ratio_of(int dimension, const Measures& m) noexcept {
  if (!(m.jacobian > 0)) return 0;
  if (dimension == 2) return 2 * std::numbers::sqrt3 * m.jacobian / m.squared_edges; // A = J / 2
  return 12 * std::cbrt(m.jacobian * m.jacobian / 4) / m.squared_edges;              // 3 V = J / 2
}

double signed_root(double x) noexcept {
  return std::copysign(std::sqrt(std::abs(x)), x);
}

/// The rows of J times the inverse of the edges' matrix.
Eigen::Matrix3d scaled_gradients(const Eigen::Matrix3d& edges) noexcept {
  Eigen::Matrix3d g;
  g.col(0) = edges.col(1).cross(edges.col(2));
  g.col(1) = edges.col(2).cross(edges.col(0));
  g.col(2) = edges.col(0).cross(edges.col(1));
  return g;
}

Eigen::Matrix2d scaled_gradients(const Eigen::Matrix2d& edges) noexcept {
  Eigen::Matrix2d g;
  g << edges(1, 1), -edges(1, 0), -edges(0, 1), edges(0, 0);
  return g;
}

/// The faces opposite the nodes a and b have the normals -grad N_a and -grad N_b. @return c |c| of the
/// largest cosine c; `gradients` are those of the nodes 1 to D, times any positive number.
template <int D>
double largest_signed_squared_cosine(const Eigen::Matrix<double, D, D>& gradients) noexcept {
  Eigen::Matrix<double, D, D + 1> normals;
  normals.template rightCols<D>() = gradients;
  normals.col(0) = -gradients.rowwise().sum();
  const Eigen::Matrix<double, 1, D + 1> inverse_squares = normals.colwise().squaredNorm().cwiseInverse();
  double largest = -1;
  for (int a = 0; a <= D; ++a)
    for (int b = a + 1; b <= D; ++b) {
      const double product = -normals.col(a).dot(normals.col(b));
      largest = std::max(largest, product * std::abs(product) * inverse_squares[a] * inverse_squares[b]);
    }
  return largest;
}

template <int D>
Measures measures_of(std::span<const double> points, std::span<const std::int32_t> nodes) noexcept {
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
  const auto gradients = scaled_gradients(edges);
  const double jacobian = edges.col(0).dot(gradients.col(0));
  if (!(jacobian > 0)) return {.jacobian = jacobian, .squared_edges = sum};
  const double power = D == 2 ? longest * longest : longest * longest * longest;
  return {jacobian, power / (jacobian * jacobian), sum, largest_signed_squared_cosine<D>(gradients)};
}

template <int D>
CellShape shape_of(std::span<const double> points, std::span<const std::int32_t> nodes) noexcept {
  const Measures m = measures_of<D>(points, nodes);
  return {m.jacobian, std::sqrt(m.squared_aspect), mean_ratio_of(D, m), signed_root(m.signed_squared_cosine)};
}

double angle_of(double cosine) noexcept {
  return degrees * std::acos(std::clamp(cosine, -1.0, 1.0));
}

/// Largest |log2| of values between `low` and `high`.
double largest_log(double low, double high) noexcept {
  if (!(low > 0) || !std::isfinite(high)) return infinity;
  return std::max(std::abs(std::log2(low)), std::abs(std::log2(high)));
}

/// A value and the cell that has it.
struct Extreme {
  double value = 0;
  std::int32_t cell = 0;
};

/// What the measures of some cells range over; of the aspect ratios and the cosine, the squares.
struct Range {
  Extreme volume_ratio{infinity, 0};
  Extreme mean_ratio{infinity, 0};
  Extreme aspect_change{0, 0}; ///< the larger of AR / AR0 and AR0 / AR
  double max_volume_ratio = -infinity;
  double min_aspect = infinity;
  double max_aspect = 0;
  double signed_squared_cosine = -1;
  double sum_of_mean_ratios = 0;

  void add(const Range& later) noexcept {
    // Written so that NaN counts as the worst, and the first of equal cells stays.
    if (!(later.volume_ratio.value >= volume_ratio.value)) volume_ratio = later.volume_ratio;
    if (later.mean_ratio.value < mean_ratio.value) mean_ratio = later.mean_ratio;
    if (later.aspect_change.value > aspect_change.value) aspect_change = later.aspect_change;
    max_volume_ratio = std::max(max_volume_ratio, later.max_volume_ratio);
    min_aspect = std::min(min_aspect, later.min_aspect);
    max_aspect = std::max(max_aspect, later.max_aspect);
    signed_squared_cosine = std::max(signed_squared_cosine, later.signed_squared_cosine);
    sum_of_mean_ratios += later.sum_of_mean_ratios;
  }
};

/// Over the cells `begin` to `end`.
template <int D>
Range range_of(std::span<const double> points, const Cells& cells, const InitialShapes& initial,
               std::size_t begin, std::size_t end) noexcept {
  Range range;
  for (std::size_t e = begin; e < end; ++e) {
    const Measures m = measures_of<D>(points, cells.cell(e));
    const auto index = static_cast<std::int32_t>(e);
    const double ratio = m.jacobian / initial.jacobians[e];
    const double mean_ratio = mean_ratio_of(D, m);
    const double aspect = m.squared_aspect / initial.squared_aspects[e];
    range.add({.volume_ratio = {ratio, index},
               .mean_ratio = {mean_ratio, index},
               .aspect_change = {std::max(aspect, 1 / aspect), index},
               .max_volume_ratio = ratio,
               .min_aspect = aspect,
               .max_aspect = aspect,
               .signed_squared_cosine = m.signed_squared_cosine,
               .sum_of_mean_ratios = mean_ratio});
  }
  return range;
}

/// Fewer cells than this a thread cost more in starting it than they save.
constexpr std::size_t cells_per_thread = 20'000;

int worthwhile(std::size_t cells) {
  return std::clamp(static_cast<int>(cells / cells_per_thread), 1,
                    std::max(1, default_threads() / la::rank_count()));
}

Range range_of(std::span<const double> points, const Cells& cells, const InitialShapes& initial) {
  WorkerPool workers(worthwhile(cells.count()));
  const auto parts = static_cast<std::size_t>(workers.size());
  std::vector<Range> ranges(parts);
  workers.run([&](int worker) {
    const auto part = static_cast<std::size_t>(worker);
    const std::size_t begin = cells.count() * part / parts, end = cells.count() * (part + 1) / parts;
    ranges[part] = with_dimension(cells.dimension,
                                  [&](auto d) { return range_of<d>(points, cells, initial, begin, end); });
  });
  for (std::size_t part = 1; part < parts; ++part) ranges[0].add(ranges[part]);
  return ranges[0];
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

Quality assess(std::span<const double> points, const Cells& cells, const InitialShapes& initial) {
  const Range range = range_of(points, cells, initial);
  Quality q;
  q.min_volume_ratio = range.volume_ratio.value;
  q.max_volume_ratio = range.max_volume_ratio;
  q.f_A = largest_log(q.min_volume_ratio, q.max_volume_ratio);
  q.f_AR = largest_log(std::sqrt(range.min_aspect), std::sqrt(range.max_aspect));
  q.worst_mean_ratio = range.mean_ratio.value;
  q.mean_mean_ratio = range.sum_of_mean_ratios / static_cast<double>(cells.count());
  q.smallest_angle = angle_of(signed_root(range.signed_squared_cosine));
  q.min_volume_element = range.volume_ratio.cell;
  q.worst_element = range.mean_ratio.cell;
  q.f_AR_element = range.aspect_change.cell;
  q.min_volume_place = centroid(points, cells.cell(static_cast<std::size_t>(q.min_volume_element)));
  q.worst_place = centroid(points, cells.cell(static_cast<std::size_t>(q.worst_element)));
  return q;
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
    shapes.squared_aspects.push_back(shape.aspect * shape.aspect);
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
