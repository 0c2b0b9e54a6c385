// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/field_projection.hpp"

#include <algorithm>
#include <cassert>
#include <set>

namespace drogue::projection {
namespace {

constexpr double same_place = 1e-8;

using Key = std::vector<std::int32_t>;

Key sorted(std::span<const std::int32_t> nodes, const std::vector<std::int32_t>& number) {
  Key key;
  for (const std::int32_t n : nodes) key.push_back(number[static_cast<std::size_t>(n)]);
  std::sort(key.begin(), key.end());
  return key;
}

/// For each fluid node the structure node at the same place, when the surfaces also have the same elements;
/// else empty.
std::vector<std::int32_t> matching_nodes(const Surface& structure, const Surface& fluid) {
  // 1. Number the nodes of both together.
  std::vector<double> all = structure.material;
  all.insert(all.end(), fluid.material.begin(), fluid.material.end());
  const Merged merged = merge_coincident(all, same_place * extent(structure.material));
  const std::size_t ns = structure.node_count(), nf = fluid.node_count();
  const std::vector<std::int32_t> on_structure(merged.group.begin(),
                                               merged.group.begin() + static_cast<std::ptrdiff_t>(ns));
  const std::vector<std::int32_t> on_fluid(merged.group.begin() + static_cast<std::ptrdiff_t>(ns),
                                           merged.group.end());
  // 2. Every structure node a number of its own, every fluid node one of them.
  std::vector<std::int32_t> node_of(static_cast<std::size_t>(merged.count), -1);
  for (std::size_t i = 0; i < ns; ++i) {
    auto& node = node_of[static_cast<std::size_t>(on_structure[i])];
    if (node >= 0) return {};
    node = static_cast<std::int32_t>(i);
  }
  std::vector<std::int32_t> copy(nf);
  for (std::size_t i = 0; i < nf; ++i) copy[i] = node_of[static_cast<std::size_t>(on_fluid[i])];
  if (std::find(copy.begin(), copy.end(), -1) != copy.end()) return {};
  // 3. The same elements.
  std::set<Key> of_structure, of_fluid;
  const Elements s(structure), f(fluid);
  for (std::int32_t e = 0; e < s.count(); ++e) of_structure.insert(sorted(s.nodes(e), on_structure));
  for (std::int32_t e = 0; e < f.count(); ++e) of_fluid.insert(sorted(f.nodes(e), on_fluid));
  return of_structure == of_fluid ? copy : std::vector<std::int32_t>{};
}

} // namespace

Result<FieldProjection> FieldProjection::create(const InterfaceQuadrature& quadrature,
                                                const Surface& structure, const Surface& fluid) {
  FieldProjection made;
  made.structure_nodes_ = structure.node_count();
  made.copy_from_ = matching_nodes(structure, fluid);
  if (made.matching()) return made;

  made.merged_ = merge_coincident(fluid.material, same_place * extent(structure.material));
  std::vector<Eigen::Triplet<double>> mass, cross;
  for (const auto& element : quadrature.elements()) {
    const auto& rule = quadrature.rule(element);
    const NodeMatrix X = gather(element.nodes, fluid.reference);
    Eigen::Matrix<double, fem::max_surface_nodes, fem::max_surface_nodes> M;
    M.setZero();
    const auto row = [&](std::size_t a) {
      return made.merged_.group[static_cast<std::size_t>(element.nodes[a])];
    };
    for (std::size_t q = 0; q < rule.weights.size(); ++q) {
      const ElementShape& shape = rule.shapes[q];
      const double da = rule.weights[q] * area_vector(shape, X).norm();
      const auto point = element.first_point + static_cast<std::int64_t>(q);
      const auto nodes = quadrature.structure_nodes(point);
      const auto N = quadrature.structure_N(point);
      for (std::size_t a = 0; a < element.nodes.size(); ++a) {
        for (std::size_t b = 0; b < element.nodes.size(); ++b)
          M(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) += da * shape.N[a] * shape.N[b];
        for (std::size_t b = 0; b < nodes.size(); ++b)
          cross.emplace_back(row(a), nodes[b], da * shape.N[a] * N[b]);
      }
    }
    for (std::size_t a = 0; a < element.nodes.size(); ++a)
      for (std::size_t b = 0; b < element.nodes.size(); ++b)
        mass.emplace_back(row(a), row(b), M(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)));
  }
  made.B_.resize(made.merged_.count, static_cast<Eigen::Index>(structure.node_count()));
  made.B_.setFromTriplets(cross.begin(), cross.end());
  la::SparseMatrix M_f(made.merged_.count, made.merged_.count);
  M_f.setFromTriplets(mass.begin(), mass.end());
  auto factored = made.M_.factor(M_f);
  if (!factored) return factored.error();
  if (!*factored)
    return config_error("the mass matrix of the {} surface is singular: raise projection.quadrature_order",
                        fluid.name);
  made.work_.resize(3 * static_cast<std::size_t>(made.merged_.count));
  return made;
}

Result<void> FieldProjection::apply(std::span<const double> structure, std::span<double> fluid,
                                    int components) {
  const auto c = static_cast<std::size_t>(components);
  assert(components >= 1 && components <= 3 && structure.size() == structure_nodes_ * c);
  if (matching()) {
    for (std::size_t i = 0; i < copy_from_.size(); ++i)
      for (std::size_t k = 0; k < c; ++k)
        fluid[i * c + k] = structure[static_cast<std::size_t>(copy_from_[i]) * c + k];
    return {};
  }
  assert(fluid.size() == merged_.group.size() * c);
  const auto n = static_cast<std::size_t>(merged_.count);
  const int* first = B_.outerIndexPtr();
  for (std::size_t a = 0; a < n; ++a) {
    double sum[3] = {0, 0, 0};
    for (int j = first[a]; j < first[a + 1]; ++j) {
      const double* d = structure.data() + static_cast<std::size_t>(B_.innerIndexPtr()[j]) * c;
      for (std::size_t k = 0; k < c; ++k) sum[k] += B_.valuePtr()[j] * d[k];
    }
    for (std::size_t k = 0; k < c; ++k) work_[k * n + a] = sum[k];
  }
  const std::span<double> columns(work_.data(), c * n);
  DROGUE_TRY(M_.solve(columns, columns, components));
  for (std::size_t i = 0; i < merged_.group.size(); ++i)
    for (std::size_t k = 0; k < c; ++k)
      fluid[i * c + k] = work_[k * n + static_cast<std::size_t>(merged_.group[i])];
  return {};
}

} // namespace drogue::projection
