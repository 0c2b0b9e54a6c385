// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/load_transfer.hpp"

#include <algorithm>
#include <cassert>

#include "coupler/projection/element_matrix.hpp"
#include "coupler/projection/surface_integrals.hpp"

namespace drogue::projection {

using Eigen::Vector3d;
using LineMatrix = Eigen::Matrix<double, 3, 2>;

namespace {

/// Values in the two nodes of a linear line, one a column.
LineMatrix gather_line(std::span<const std::int32_t> nodes, std::span<const double> values) {
  LineMatrix X;
  for (std::size_t a = 0; a < 2; ++a)
    X.col(static_cast<Eigen::Index>(a)) =
        Eigen::Map<const Vector3d>(values.data() + 3 * static_cast<std::size_t>(nodes[a]));
  return X;
}

/// area_vector() of a linear line.
Vector3d line_area(const LineMatrix& X) {
  const Vector3d along = X.col(1) - X.col(0);
  return {0.5 * along.y(), -0.5 * along.x(), 0};
}

} // namespace

Result<LoadTransfer> LoadTransfer::create(InterfaceQuadrature quadrature, const Surface& structure,
                                          const Surface& fluid, bool recover_traction) {
  LoadTransfer made;
  made.structure_nodes_ = structure.node_count();
  made.quadrature_ = std::move(quadrature);
  made.sort_elements();
  if (!recover_traction) return made;
  made.work_.resize(3 * made.structure_nodes_);
  DROGUE_TRY(made.factor_recovery(structure, fluid));
  return made;
}

void LoadTransfer::sort_elements() {
  const auto& elements = quadrature_.elements();
  for (std::size_t e = 0; e < elements.size(); ++e) {
    const auto& element = elements[e];
    if (element.kind != mesh::ElementKind::tri3) {
      other_elements_.push_back(static_cast<std::int32_t>(e));
      continue;
    }
    triangle_nodes_.insert(triangle_nodes_.end(), element.nodes.begin(), element.nodes.end());
    triangle_rows_.push_back({element.first_node, element.first_value, element.node_count});
  }
  if (!triangle_rows_.empty()) triangle_forces_.resize(4 * structure_nodes_);
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

void LoadTransfer::add_line(const InterfaceQuadrature::Element& element, const LineMatrix& G,
                            std::span<double> forces) const noexcept {
  const double* C = quadrature_.block(element);
  for (const std::int32_t node : quadrature_.block_nodes(element)) {
    Eigen::Map<Vector3d>(forces.data() + 3 * static_cast<std::size_t>(node)) +=
        C[0] * G.col(0) + C[1] * G.col(1);
    C += 2;
  }
}

/// The sums of a load with the values G in the nodes of a line: its mass matrix is (1 + delta_bc) / 3.
void LoadTransfer::add_line_sums(const InterfaceQuadrature::Element& element, const LineMatrix& G,
                                 const LineMatrix& X, const FluidSide& fluid, LoadSums& sums) noexcept {
  constexpr double k = 1.0 / 3;
  const Vector3d whole = G.col(0) + G.col(1);
  sums.force += 3 * k * whole;
  sums.moment +=
      k * ((X.col(0) + X.col(1)).cross(whole) + X.col(0).cross(G.col(0)) + X.col(1).cross(G.col(1)));
  if (fluid.velocity.empty()) return;
  const LineMatrix V = gather_line(element.nodes, fluid.velocity);
  sums.power += k * ((V.col(0) + V.col(1)).dot(whole) + V.cwiseProduct(G).sum());
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

/// @param triangles kernel for the linear triangles, and the load it takes
/// @param line_load on linear lines: (nodes, area vector) -> t times its length in each node, one a column
/// @param load_on nodes -> (shape, area vector times weight -> force on the point's share of the surface)
template <class LineLoad, class LoadOn>
LoadSums LoadTransfer::transfer(const FluidSide& fluid, TriangleKernel triangles,
                                std::span<const double> load, std::span<double> forces,
                                const LineLoad& line_load, const LoadOn& load_on) noexcept {
  assert(forces.size() == 3 * structure_nodes_);
  std::fill(forces.begin(), forces.end(), 0.0);
  const bool moving = !fluid.velocity.empty();
  LoadSums sums;
  if (!triangle_rows_.empty()) {
    std::fill(triangle_forces_.begin(), triangle_forces_.end(), 0.0);
    const FlatTriangles all{static_cast<std::int32_t>(triangle_rows_.size()), triangle_nodes_.data(),
                            triangle_rows_.data(), quadrature_.all_block_nodes(), quadrature_.all_blocks()};
    const FlatSums of_triangles =
        triangles(all, {fluid.points.data(), moving ? fluid.velocity.data() : nullptr}, load.data(),
                  triangle_forces_.data());
    sums.force = Eigen::Map<const Vector3d>(of_triangles.force.data());
    sums.moment = Eigen::Map<const Vector3d>(of_triangles.moment.data());
    sums.power = of_triangles.power;
    for (std::size_t i = 0; i < structure_nodes_; ++i)
      std::copy_n(triangle_forces_.begin() + static_cast<std::ptrdiff_t>(4 * i), 3,
                  forces.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  for (const std::int32_t e : other_elements_) {
    const auto& element = quadrature_.elements()[static_cast<std::size_t>(e)];
    if (element.rule < 0) {
      const LineMatrix X = gather_line(element.nodes, fluid.points);
      const LineMatrix G = line_load(element.nodes, line_area(X));
      add_line_sums(element, G, X, fluid, sums);
      add_line(element, G, forces);
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
                                     std::span<double> forces) noexcept {
  const auto line = [&](std::span<const std::int32_t> nodes, const Vector3d& area) {
    LineMatrix G;
    for (std::size_t b = 0; b < 2; ++b)
      G.col(static_cast<Eigen::Index>(b)) = pressure[static_cast<std::size_t>(nodes[b])] * area;
    return G;
  };
  const auto triangles = projection_kernels().load_of_pressure;
  return transfer(fluid, triangles, pressure, forces, line, [&](std::span<const std::int32_t> nodes) {
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
                                     std::span<double> forces) noexcept {
  const auto line = [&](std::span<const std::int32_t> nodes, const Vector3d& area) {
    return LineMatrix(area.norm() * gather_line(nodes, traction));
  };
  const auto triangles = projection_kernels().load_of_traction;
  return transfer(fluid, triangles, traction, forces, line, [&](std::span<const std::int32_t> nodes) {
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
