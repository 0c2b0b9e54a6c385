// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/load_transfer.hpp"

#include <algorithm>
#include <cassert>

#include "coupler/projection/element_matrix.hpp"
#include "coupler/projection/surface_integrals.hpp"

namespace drogue::projection {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Nodal values of a flat element, one a column; the third column is zero on lines.
Matrix3d gather_flat(std::span<const std::int32_t> nodes, std::span<const double> values) {
  Matrix3d X = Matrix3d::Zero();
  for (std::size_t a = 0; a < nodes.size(); ++a)
    X.col(static_cast<Eigen::Index>(a)) =
        Eigen::Map<const Vector3d>(values.data() + 3 * static_cast<std::size_t>(nodes[a]));
  return X;
}

/// area_vector() of a flat element.
Vector3d flat_area(mesh::ElementKind kind, const Matrix3d& X) {
  const Vector3d along = X.col(1) - X.col(0);
  return kind == mesh::ElementKind::line2 ? Vector3d(0.5 * along.y(), -0.5 * along.x(), 0)
                                          : Vector3d(along.cross(X.col(2) - X.col(0)));
}

} // namespace

Result<LoadTransfer> LoadTransfer::create(InterfaceQuadrature quadrature, const Surface& structure,
                                          const Surface& fluid, bool recover_traction) {
  LoadTransfer made;
  made.structure_nodes_ = structure.node_count();
  made.quadrature_ = std::move(quadrature);
  if (!recover_traction) return made;
  made.work_.resize(3 * made.structure_nodes_);
  DROGUE_TRY(made.factor_recovery(structure, fluid));
  return made;
}

/// M_ab = int N_a N_b dA over what is wet, one layer of fluid; dry elements get their own mass matrix.
Result<void> LoadTransfer::factor_recovery(const Surface& structure, const Surface& fluid) {
  const Elements& elements = quadrature_.structure_elements();
  const auto n = static_cast<std::int32_t>(structure_nodes_);
  const auto nodes_of = [&](std::int32_t e) { return elements.nodes(e); };
  std::vector<double> own; // of the dry elements, wet parts included
  std::vector<std::int64_t> own_first(static_cast<std::size_t>(elements.count()), -1);
  for (std::int32_t e = 0; e < elements.count(); ++e) {
    if (quadrature_.wet(e)) continue;
    const auto nodes = elements.nodes(e);
    const ElementMass mass = element_mass(elements.kind(e), gather(nodes, structure.reference));
    own_first[static_cast<std::size_t>(e)] = static_cast<std::int64_t>(own.size());
    for (std::size_t a = 0; a < nodes.size(); ++a)
      for (std::size_t b = 0; b < nodes.size(); ++b)
        own.push_back(quadrature_.wet_mass(e)[a * nodes.size() + b] +
                      mass.M(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)));
  }
  const auto part_of = [&](std::int32_t e) {
    const std::int64_t first = own_first[static_cast<std::size_t>(e)];
    const auto nodes = elements.nodes(e);
    return ElementPart{nodes,        nodes, first < 0 ? quadrature_.wet_mass(e) : own.data() + first,
                       nodes.size(), 1,     1};
  };
  auto factored = M_.factor(
      upper_triangle(sum_elements(n, n, elements_around(n, elements.count(), nodes_of), part_of, true)));
  if (!factored) return factored.error();
  if (!*factored)
    return config_error(
        "the tractions on the {} surface cannot be recovered from the points of the {} surface: raise "
        "projection.quadrature_order",
        structure.name, fluid.name);
  return {};
}

void LoadTransfer::add_flat(const InterfaceQuadrature::Element& element, const Matrix3d& G,
                            std::span<double> forces) const noexcept {
  const auto nodes = quadrature_.block_nodes(element);
  const double *C = quadrature_.block(element), *g = G.data();
  const std::size_t m = element.nodes.size();
  for (std::size_t a = 0; a < nodes.size(); ++a, C += m) {
    double* at = forces.data() + 3 * static_cast<std::size_t>(nodes[a]);
    const double c0 = C[0], c1 = C[1], c2 = m == 3 ? C[2] : 0;
    at[0] += c0 * g[0] + c1 * g[3] + c2 * g[6];
    at[1] += c0 * g[1] + c1 * g[4] + c2 * g[7];
    at[2] += c0 * g[2] + c1 * g[5] + c2 * g[8];
  }
}

/// The sums of a load with the values G in the nodes of a flat element: its mass matrix is k (1 + delta_bc),
/// with k = 1/24 on triangles and 1/3 on lines, where the third column is zero.
void LoadTransfer::add_flat_sums(const InterfaceQuadrature::Element& element, const Matrix3d& G,
                                 const Matrix3d& X, const FluidSide& fluid, LoadSums& sums) noexcept {
  const std::size_t m = element.nodes.size();
  const double k = m == 3 ? 1.0 / 24 : 1.0 / 3;
  const Vector3d whole = G.col(0) + G.col(1) + G.col(2);
  sums.force += k * static_cast<double>(m + 1) * whole;
  sums.moment += k * ((X.col(0) + X.col(1) + X.col(2)).cross(whole) + X.col(0).cross(G.col(0)) +
                      X.col(1).cross(G.col(1)) + X.col(2).cross(G.col(2)));
  if (fluid.velocity.empty()) return;
  const Matrix3d V = gather_flat(element.nodes, fluid.velocity);
  sums.power += k * ((V.col(0) + V.col(1) + V.col(2)).dot(whole) + V.cwiseProduct(G).sum());
}

void LoadTransfer::add_at_point(std::int64_t point, const Vector3d& f,
                                std::span<double> forces) const noexcept {
  const auto nodes = quadrature_.structure_nodes(point);
  const auto N = quadrature_.structure_N(point);
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    double* at = forces.data() + 3 * static_cast<std::size_t>(nodes[a]);
    for (Eigen::Index k = 0; k < 3; ++k) at[k] += N[a] * f[k];
  }
}

/// @param flat_load (nodes, area vector) -> t times its length in each node, one a column
/// @param load_on nodes -> (shape, area vector times weight -> force on the point's share of the surface)
template <class FlatLoad, class LoadOn>
LoadSums LoadTransfer::transfer(const FluidSide& fluid, std::span<double> forces, const FlatLoad& flat_load,
                                const LoadOn& load_on) const noexcept {
  assert(forces.size() == 3 * structure_nodes_);
  std::fill(forces.begin(), forces.end(), 0.0);
  const bool moving = !fluid.velocity.empty();
  LoadSums sums;
  for (const auto& element : quadrature_.elements()) {
    if (element.rule < 0) {
      const Matrix3d X = gather_flat(element.nodes, fluid.points);
      const Matrix3d G = flat_load(element.nodes, flat_area(element.kind, X));
      add_flat_sums(element, G, X, fluid, sums);
      add_flat(element, G, forces);
      continue;
    }
    const auto& rule = quadrature_.rule(element);
    const NodeMatrix X = gather(element.nodes, fluid.points);
    const NodeMatrix V = moving ? gather(element.nodes, fluid.velocity) : NodeMatrix::Zero();
    const auto force_at = load_on(element.nodes);
    for (std::size_t q = 0; q < rule.weights.size(); ++q) {
      const ElementShape& shape = rule.shapes[q];
      const Vector3d f = force_at(shape, rule.weights[q] * area_vector(shape, X));
      sums.force += f;
      sums.moment += combine(shape.N, shape.nodes, X).cross(f);
      if (moving) sums.power += f.dot(combine(shape.N, shape.nodes, V));
      add_at_point(element.first_point + static_cast<std::int64_t>(q), f, forces);
    }
  }
  return sums;
}

LoadSums LoadTransfer::from_pressure(const FluidSide& fluid, std::span<const double> pressure,
                                     std::span<double> forces) const noexcept {
  const auto flat = [&](std::span<const std::int32_t> nodes, const Vector3d& area) {
    Matrix3d G = Matrix3d::Zero();
    for (std::size_t b = 0; b < nodes.size(); ++b)
      G.col(static_cast<Eigen::Index>(b)) = pressure[static_cast<std::size_t>(nodes[b])] * area;
    return G;
  };
  return transfer(fluid, forces, flat, [&](std::span<const std::int32_t> nodes) {
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
  const auto flat = [&](std::span<const std::int32_t> nodes, const Vector3d& area) {
    return Matrix3d(area.norm() * gather_flat(nodes, traction));
  };
  return transfer(fluid, forces, flat, [&](std::span<const std::int32_t> nodes) {
    return [t = gather(nodes, traction)](const ElementShape& shape, const Vector3d& area) {
      return Vector3d(area.norm() * combine(shape.N, shape.nodes, t));
    };
  });
}

Result<void> LoadTransfer::recover_traction(std::span<const double> forces, std::span<double> traction) {
  const std::size_t n = structure_nodes_;
  if (work_.empty()) return internal_error("the recovery of tractions was not asked for");
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
