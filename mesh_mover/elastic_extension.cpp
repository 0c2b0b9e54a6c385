// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/elastic_extension.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace drogue::mesh_mover {
namespace {

/// Below this fraction of the load the residual is rounding.
constexpr double rounding = 1e-13;

} // namespace

ElasticExtension::ElasticExtension(ExtensionInput input, bool share)
    : input_(std::move(input)),
      solid_(pseudo_solid(input_.numbers.poisson_ratio, input_.numbers.stiffening_exponent,
                          input_.numbers.mean_jacobian)),
      stiffness_(input_.cells, input_.given, std::move(input_.factors), share),
      solver_(stiffness_.matrix(), stiffness_.given_rows(), input_.cells.dimension,
              input_.numbers.linear_solver, stiffness_.rows()),
      load_(3 * input_.given.size()),
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
  const double tolerance = std::max(input_.numbers.tolerance * reference, rounding * free_norm(load_));
  // 2. the linear system, in the numbering of the matrix
  stiffness_.to_rows(load_, load_rows_);
  stiffness_.to_rows(u, u_rows_);
  auto outcome = solver_.solve(load_rows_, u_rows_, tolerance, input_.numbers.max_iterations);
  if (!outcome) return outcome;
  stiffness_.to_nodes(u_rows_, u);
  if (reference > 0) outcome->residual /= reference;
  return outcome;
}

} // namespace drogue::mesh_mover
