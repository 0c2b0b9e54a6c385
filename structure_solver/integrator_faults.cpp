// SPDX-License-Identifier: GPL-3.0-or-later
//
// What to say when a step fails: the nodes that are furthest from balance, and motions without stiffness.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "structure_solver/integrator.hpp"
#include "structure_solver/node_name.hpp"

namespace drogue::structure {
namespace {

double nodal_norm(std::span<const double> x, std::size_t node) {
  const double square =
      x[3 * node] * x[3 * node] + x[3 * node + 1] * x[3 * node + 1] + x[3 * node + 2] * x[3 * node + 2];
  return std::isnan(square) ? HUGE_VAL : std::sqrt(square);
}

/// Stiffness of a motion, relative to the largest entry of the diagonal, below which it counts as none.
constexpr double no_stiffness = 1e-13;
constexpr int inverse_iterations = 4;

} // namespace

std::string Integrator::worst_nodes() const {
  constexpr std::size_t count = 3;
  std::vector<std::size_t> nodes(model_.node_count());
  std::iota(nodes.begin(), nodes.end(), std::size_t{0});
  const std::size_t shown = std::min(count, nodes.size());
  std::partial_sort(nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(shown), nodes.end(),
                    [&](std::size_t a, std::size_t b) {
                      const double ra = nodal_norm(residual_, a), rb = nodal_norm(residual_, b);
                      return ra != rb ? ra > rb : a < b;
                    });
  std::string text = "; the largest residuals:";
  for (std::size_t k = 0; k < shown; ++k) {
    const auto node = static_cast<std::int32_t>(nodes[k]);
    const double r = nodal_norm(residual_, nodes[k]);
    text += fmt::format("\n  {} at {}", std::isfinite(r) ? fmt::format("{:.3g}", r) : "not finite",
                        node_name(model_.mesh, node));
  }
  return text;
}

Result<void> Integrator::check_mechanism() {
  const auto loads = evaluate_loads(model_, n_.time, load_factor(n_.time));
  if (!loads) return loads.error();
  assembler_.assemble({.displacement = n_.u, .load_displacement = n_.u, .loads = *loads, .tangent = true},
                      residual_);
  assembler_.eliminate_held();
  const la::SparseMatrix K = assembler_.tangent();
  const Eigen::VectorXd diagonal = K.diagonal();
  double largest = 0;
  for (std::size_t i = 0; i < model_.held.size(); ++i)
    if (!model_.held[i]) largest = std::max(largest, std::abs(diagonal(static_cast<Eigen::Index>(i))));
  if (!(largest > 0)) return {};
  la::SparseMatrix shifted = K;
  for (Eigen::Index i = 0; i < diagonal.size(); ++i) shifted.coeffRef(i, i) += no_stiffness * largest;
  la::LuSolver solver;
  const auto factored = solver.factor(shifted);
  if (!factored) return factored.error();
  Eigen::VectorXd x(diagonal.size());
  for (Eigen::Index i = 0; i < x.size(); ++i)
    x(i) = model_.held[static_cast<std::size_t>(i)] ? 0 : 1 + std::sin(static_cast<double>(i));
  double stiffness = 0;
  for (int k = 0; *factored && k < inverse_iterations; ++k) {
    x.normalize();
    Eigen::VectorXd next(x.size());
    DROGUE_TRY(solver.solve({x.data(), static_cast<std::size_t>(x.size())},
                            {next.data(), static_cast<std::size_t>(x.size())}));
    if (!next.allFinite()) break;
    x = next.normalized();
    stiffness = std::abs(x.dot(K * x)) / largest;
  }
  if (*factored && stiffness > no_stiffness) return {};
  std::size_t node = 0;
  for (std::size_t i = 1; i < model_.node_count(); ++i)
    if (nodal_norm({x.data(), model_.equation_count()}, i) >
        nodal_norm({x.data(), model_.equation_count()}, node))
      node = i;
  return config_error("the structure is a mechanism: nothing resists a motion whose largest part is at {}; "
                      "hold it, give a prestress or a "
                      "state that carries load, or use STATIC_BY_DAMPED_DYNAMICS",
                      node_name(model_.mesh, static_cast<std::int32_t>(node)));
}

} // namespace drogue::structure
