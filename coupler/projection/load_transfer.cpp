// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/load_transfer.hpp"

#include <algorithm>
#include <cassert>

#include "coupler/projection/surface_integrals.hpp"

namespace drogue::projection {

using Eigen::Vector3d;

Result<LoadTransfer> LoadTransfer::create(const InterfaceQuadrature& quadrature, const Surface& structure,
                                          const Surface& fluid) {
  LoadTransfer made;
  made.quadrature_ = quadrature;
  made.structure_nodes_ = structure.node_count();
  made.work_.resize(3 * made.structure_nodes_);
  DROGUE_TRY(made.factor_recovery(structure, fluid));
  return made;
}

/// M_ab = sum over the points of N_a(pi) N_b(pi) dA, one layer of fluid; dry elements get their own mass
/// matrix.
Result<void> LoadTransfer::factor_recovery(const Surface& structure, const Surface& fluid) {
  std::vector<Eigen::Triplet<double>> mass;
  for (const auto& element : quadrature_.elements()) {
    const auto& rule = quadrature_.rule(element);
    const NodeMatrix X = gather(element.nodes, fluid.reference);
    for (std::size_t q = 0; q < rule.weights.size(); ++q) {
      const double da = element.share * rule.weights[q] * area_vector(rule.shapes[q], X).norm();
      const auto point = element.first_point + static_cast<std::int64_t>(q);
      const auto nodes = quadrature_.structure_nodes(point);
      const auto N = quadrature_.structure_N(point);
      for (std::size_t a = 0; a < nodes.size(); ++a)
        for (std::size_t b = 0; b < nodes.size(); ++b)
          mass.emplace_back(nodes[a], nodes[b], da * N[a] * N[b]);
    }
  }
  const Elements elements(structure);
  for (std::int32_t e = 0; e < elements.count(); ++e) {
    const auto nodes = elements.nodes(e);
    const ElementMass own = element_mass(elements.kind(e), gather(nodes, structure.reference));
    const double wet = quadrature_.area_on()[static_cast<std::size_t>(e)];
    const auto points = static_cast<std::size_t>(quadrature_.points_on()[static_cast<std::size_t>(e)]);
    if (wet >= dry_share * own.area && points >= nodes.size()) continue;
    for (std::size_t a = 0; a < nodes.size(); ++a)
      for (std::size_t b = 0; b < nodes.size(); ++b)
        mass.emplace_back(nodes[a], nodes[b],
                          own.M(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)));
  }
  const auto n = static_cast<Eigen::Index>(structure_nodes_);
  la::SparseMatrix M(n, n);
  M.setFromTriplets(mass.begin(), mass.end());
  auto factored = M_.factor(M);
  if (!factored) return factored.error();
  if (!*factored)
    return config_error(
        "the tractions on the {} surface cannot be recovered from the points of the {} surface: raise "
        "projection.quadrature_order",
        structure.name, fluid.name);
  return {};
}

/// @param load_on element's nodes -> (shape, area vector times weight -> force on the point's share of the
/// surface)
template <class LoadOn>
LoadSums LoadTransfer::transfer(const FluidSide& fluid, std::span<double> forces,
                                const LoadOn& load_on) const noexcept {
  assert(forces.size() == 3 * structure_nodes_);
  std::fill(forces.begin(), forces.end(), 0.0);
  const bool moving = !fluid.velocity.empty();
  LoadSums sums;
  for (const auto& element : quadrature_.elements()) {
    const auto& rule = quadrature_.rule(element);
    const NodeMatrix X = gather(element.nodes, fluid.points);
    const NodeMatrix V = moving ? gather(element.nodes, fluid.velocity) : NodeMatrix::Zero();
    const auto force_at = load_on(element.nodes);
    const bool flat = rule.kind == mesh::ElementKind::tri3 || rule.kind == mesh::ElementKind::line2;
    Vector3d area = area_vector(rule.shapes[0], X);
    for (std::size_t q = 0; q < rule.weights.size(); ++q) {
      const ElementShape& shape = rule.shapes[q];
      if (!flat) area = area_vector(shape, X);
      const Vector3d f = force_at(shape, rule.weights[q] * area);
      sums.force += f;
      sums.moment += combine(shape.N, shape.nodes, X).cross(f);
      if (moving) sums.power += f.dot(combine(shape.N, shape.nodes, V));
      const auto point = element.first_point + static_cast<std::int64_t>(q);
      const auto nodes = quadrature_.structure_nodes(point);
      const auto N = quadrature_.structure_N(point);
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        double* at = forces.data() + 3 * static_cast<std::size_t>(nodes[a]);
        for (Eigen::Index k = 0; k < 3; ++k) at[k] += N[a] * f[k];
      }
    }
  }
  return sums;
}

LoadSums LoadTransfer::from_pressure(const FluidSide& fluid, std::span<const double> pressure,
                                     std::span<double> forces) const noexcept {
  return transfer(fluid, forces, [&](std::span<const std::int32_t> nodes) {
    std::array<double, fem::max_surface_nodes> p{};
    for (std::size_t b = 0; b < nodes.size(); ++b) p[b] = pressure[static_cast<std::size_t>(nodes[b])];
    return [p](const ElementShape& shape, const Vector3d& area) {
      double at = 0;
      for (std::size_t b = 0; b < static_cast<std::size_t>(shape.nodes); ++b) at += shape.N[b] * p[b];
      return Vector3d(at * area);
    };
  });
}

LoadSums LoadTransfer::from_traction(const FluidSide& fluid, std::span<const double> traction,
                                     std::span<double> forces) const noexcept {
  return transfer(fluid, forces, [&](std::span<const std::int32_t> nodes) {
    return [t = gather(nodes, traction)](const ElementShape& shape, const Vector3d& area) {
      return Vector3d(area.norm() * combine(shape.N, shape.nodes, t));
    };
  });
}

Result<void> LoadTransfer::recover_traction(std::span<const double> forces, std::span<double> traction) {
  const std::size_t n = structure_nodes_;
  assert(forces.size() == 3 * n && traction.size() == 3 * n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < 3; ++k) work_[k * n + i] = forces[3 * i + k];
  DROGUE_TRY(M_.solve(work_, work_, 3));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < 3; ++k) traction[3 * i + k] = work_[k * n + i];
  return {};
}

LoadSums sum_nodal(std::span<const double> points, std::span<const double> forces,
                   std::span<const double> velocity) noexcept {
  LoadSums sums;
  for (std::size_t i = 0; i + 2 < forces.size(); i += 3) {
    const Vector3d f(forces[i], forces[i + 1], forces[i + 2]);
    sums.force += f;
    sums.moment += Vector3d(points[i], points[i + 1], points[i + 2]).cross(f);
    if (!velocity.empty()) sums.power += f.dot(Vector3d(velocity[i], velocity[i + 1], velocity[i + 2]));
  }
  return sums;
}

} // namespace drogue::projection
