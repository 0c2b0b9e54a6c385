// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/elastic_extension.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace drogue::mesh_mover {
namespace {

/// Below this fraction of the load the residual is rounding.
constexpr double rounding = 1e-13;

double mean(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// `factor` for the elements that touch `nodes`, and for those around them up to `layers` elements deep; 1
/// for the others. Empty without layers.
std::vector<double> layer_factors(const Cells& cells, std::size_t node_count,
                                  std::span<const std::int32_t> nodes, const StiffLayers& stiff) {
  if (stiff.layers == 0) return {};
  std::vector<double> factors(cells.count(), 1.0);
  std::vector<bool> is_near(node_count, false);
  for (const std::int32_t node : nodes) is_near[static_cast<std::size_t>(node)] = true;
  std::vector<std::int32_t> reached;
  for (int layer = 0; layer < stiff.layers; ++layer) {
    reached.clear();
    for (std::size_t e = 0; e < cells.count(); ++e) {
      const auto cell = cells.cell(e);
      if (std::none_of(cell.begin(), cell.end(),
                       [&](std::int32_t node) { return is_near[static_cast<std::size_t>(node)]; }))
        continue;
      factors[e] = stiff.factor;
      reached.insert(reached.end(), cell.begin(), cell.end());
    }
    for (const std::int32_t node : reached) is_near[static_cast<std::size_t>(node)] = true;
  }
  return factors;
}

} // namespace

ElasticExtension::ElasticExtension(const Settings& settings, const Cells& cells, const BoundaryMotion& motion,
                                   std::span<const double> initial_jacobians)
    : solid_(pseudo_solid(settings.poisson_ratio, settings.stiffening_exponent, mean(initial_jacobians))),
      tolerance_(settings.tolerance),
      max_iterations_(settings.max_iterations),
      stiffness_(
          cells, motion.given(),
          layer_factors(cells, motion.given().size(), motion.displaced_nodes(), settings.stiff_layers)),
      solver_(stiffness_.matrix(), stiffness_.given_rows(), cells.dimension, settings.linear_solver),
      load_(3 * motion.given().size()),
      work_(load_),
      load_rows_(load_),
      u_rows_(load_) {}

Result<void> ElasticExtension::prepare(std::span<const double> points) {
  stiffness_.assemble(solid_, points);
  stiffness_.to_rows(points, u_rows_);
  return solver_.update(u_rows_);
}

double ElasticExtension::free_norm(std::span<const double> f) const {
  double sum = 0;
  for (std::size_t i = 0; i < f.size() / 3; ++i)
    for (int c = 0; c < 3; ++c)
      if (!stiffness_.is_given(i, c))
        sum += f[3 * i + static_cast<std::size_t>(c)] * f[3 * i + static_cast<std::size_t>(c)];
  return std::sqrt(sum);
}

Result<SolveOutcome> ElasticExtension::extend(std::span<double> u, std::span<const double> increment) {
  // 1. load, and the norm against which the residual is measured
  stiffness_.boundary_load(increment, work_);
  const double reference = free_norm(work_);
  stiffness_.boundary_load(u, load_);
  const double tolerance = std::max(tolerance_ * reference, rounding * free_norm(load_));
  // 2. the linear system, in the numbering of the matrix
  stiffness_.to_rows(load_, load_rows_);
  stiffness_.to_rows(u, u_rows_);
  auto outcome = solver_.solve(load_rows_, u_rows_, tolerance, max_iterations_);
  if (!outcome) return outcome;
  stiffness_.to_nodes(u_rows_, u);
  if (reference > 0) outcome->residual /= reference;
  return outcome;
}

} // namespace drogue::mesh_mover
