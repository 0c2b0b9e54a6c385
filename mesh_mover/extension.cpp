// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/extension.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/la_krylov/session.hpp"
#include "mesh_mover/algebraic_extension.hpp"
#include "mesh_mover/elastic_extension.hpp"
#include "mesh_mover/shared_extension.hpp"

namespace drogue::mesh_mover {
namespace {

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

/// Direct factors are made by one process.
bool is_shared(const ExtensionInput& input) {
  return la::rank_count() > 1 &&
         (input.method == Method::algebraic ||
          !is_direct(input.numbers.linear_solver, input.given.size(), input.cells.dimension));
}

} // namespace

std::unique_ptr<Extension> make_extension(ExtensionInput input, bool share) {
  if (input.method == Method::algebraic) return std::make_unique<AlgebraicExtension>(std::move(input), share);
  return std::make_unique<ElasticExtension>(std::move(input), share);
}

ExtensionInput extension_input(const Settings& settings, const Cells& cells, const BoundaryMotion& motion,
                               std::span<const double> initial_jacobians) {
  ExtensionInput input{.method = settings.method,
                       .cells = cells,
                       .given = motion.given(),
                       .factors = {},
                       .bodies = {},
                       .numbers = {.poisson_ratio = settings.poisson_ratio,
                                   .stiffening_exponent = settings.stiffening_exponent,
                                   .mean_jacobian = mean(initial_jacobians),
                                   .tolerance = settings.tolerance,
                                   .weight_exponent = settings.weight_exponent,
                                   .max_iterations = settings.max_iterations,
                                   .linear_solver = settings.linear_solver}};
  if (settings.method == Method::elastic) {
    input.factors =
        layer_factors(cells, motion.given().size(), motion.displaced_nodes(), settings.stiff_layers);
    return input;
  }
  for (std::size_t k = 0; k < motion.boundaries().size(); ++k)
    if (motion.boundaries()[k].condition == Condition::displacement && !motion.owned_nodes(k).empty())
      input.bodies.push_back(motion.owned_nodes(k));
  return input;
}

std::unique_ptr<Extension> make_extension(const Settings& settings, const Cells& cells,
                                          const BoundaryMotion& motion,
                                          std::span<const double> initial_jacobians) {
  ExtensionInput input = extension_input(settings, cells, motion, initial_jacobians);
  if (is_shared(input)) return std::make_unique<SharedExtension>(std::move(input));
  return make_extension(std::move(input), false);
}

} // namespace drogue::mesh_mover
