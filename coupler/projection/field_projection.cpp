// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/field_projection.hpp"

#include <algorithm>
#include <cassert>
#include <set>

#include "coupler/projection/element_matrix.hpp"

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

/// int N_b N_c dA over the reference area by the points of a curved element.
void add_curved_mass(const InterfaceQuadrature& quadrature, const InterfaceQuadrature::Element& element,
                     const Surface& fluid, std::vector<double>& masses) {
  const auto& rule = quadrature.rule(element);
  const NodeMatrix X = gather(element.nodes, fluid.reference);
  const std::size_t n = element.nodes.size(), start = masses.size();
  masses.resize(start + n * n, 0.0);
  for (std::size_t q = 0; q < rule.weights.size(); ++q) {
    const ElementShape& shape = rule.shapes[q];
    const double da = rule.weights[q] * area_vector(shape, X).norm();
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n; ++b) masses[start + a * n + b] += da * shape.N[a] * shape.N[b];
  }
}

} // namespace

Result<FieldProjection> FieldProjection::create(const InterfaceQuadrature& quadrature,
                                                const Surface& structure, const Surface& fluid) {
  FieldProjection made;
  made.structure_nodes_ = structure.node_count();
  made.copy_from_ = matching_nodes(structure, fluid);
  if (made.matching()) return made;

  made.merged_ = merge_coincident(fluid.material, same_place * extent(structure.material));
  // 1. The unknowns of each element, and its mass matrix by the same points as its products with the
  // structure.
  const auto& elements = quadrature.elements();
  std::vector<std::int32_t> unknowns;
  std::vector<std::size_t> first{0}, first_mass;
  std::vector<double> curved_mass, scale;
  for (const auto& element : elements) {
    for (const std::int32_t i : element.nodes)
      unknowns.push_back(made.merged_.group[static_cast<std::size_t>(i)]);
    first.push_back(unknowns.size());
    first_mass.push_back(curved_mass.size());
    const bool flat = element.rule < 0;
    if (!flat) add_curved_mass(quadrature, element, fluid, curved_mass);
    scale.push_back(
        flat ? area_vector(element_shape(element.kind, 0, 0), gather(element.nodes, fluid.reference)).norm()
             : 1);
  }
  const auto rows = [&](std::int32_t e) {
    const auto i = static_cast<std::size_t>(e);
    return std::span<const std::int32_t>(unknowns.data() + first[i], first[i + 1] - first[i]);
  };
  const auto mass = [&](std::int32_t e) {
    const auto i = static_cast<std::size_t>(e);
    const bool flat = elements[i].rule < 0;
    return ElementPart{rows(e),
                       rows(e),
                       flat ? flat_mass(elements[i].kind).data() : curved_mass.data() + first_mass[i],
                       flat ? 3 : elements[i].nodes.size(),
                       1,
                       scale[i]};
  };
  const auto cross = [&](std::int32_t e) {
    const auto& element = elements[static_cast<std::size_t>(e)];
    return ElementPart{rows(e),
                       quadrature.block_nodes(element),
                       quadrature.block(element),
                       1,
                       element.nodes.size(),
                       scale[static_cast<std::size_t>(e)]};
  };
  // 2. The sums.
  const std::int32_t count = made.merged_.count;
  const Adjacency around = elements_around(count, static_cast<std::int32_t>(elements.size()), rows);
  made.B_ = sum_elements(count, static_cast<std::int32_t>(structure.node_count()), around, cross);
  const la::SparseMatrix M_f = upper_triangle(sum_elements(count, count, around, mass, true));
  auto factored = made.M_.factor(M_f);
  if (!factored) return factored.error();
  if (!*factored)
    return config_error("the mass matrix of the {} surface is singular: raise projection.quadrature_order",
                        fluid.name);
  return made;
}

void FieldProjection::copy(const Transfer& field, std::size_t c) const {
  for (std::size_t i = 0; i < copy_from_.size(); ++i)
    for (std::size_t k = 0; k < c; ++k)
      field.fluid[i * c + k] = field.structure[static_cast<std::size_t>(copy_from_[i]) * c + k];
}

/// {components, unknowns}, relative to the first node: rounding is that of the differences, and none is left
/// of constants.
void FieldProjection::multiply(const Transfer& field, std::size_t c, double* product) const {
  const auto n = static_cast<std::size_t>(merged_.count);
  const int* first = B_.outerIndexPtr();
  for (std::size_t a = 0; a < n; ++a) {
    double sum[3] = {0, 0, 0};
    for (int j = first[a]; j < first[a + 1]; ++j) {
      const double* d = field.structure.data() + static_cast<std::size_t>(B_.innerIndexPtr()[j]) * c;
      for (std::size_t k = 0; k < c; ++k) sum[k] += B_.valuePtr()[j] * (d[k] - field.structure[k]);
    }
    for (std::size_t k = 0; k < c; ++k) product[k * n + a] = sum[k];
  }
}

void FieldProjection::spread(const double* solution, const Transfer& field, std::size_t c) const {
  const auto n = static_cast<std::size_t>(merged_.count);
  for (std::size_t i = 0; i < merged_.group.size(); ++i)
    for (std::size_t k = 0; k < c; ++k)
      field.fluid[i * c + k] =
          field.structure[k] + solution[k * n + static_cast<std::size_t>(merged_.group[i])];
}

Result<void> FieldProjection::apply(std::span<const Transfer> fields, int components) {
  const auto c = static_cast<std::size_t>(components);
  assert(components >= 1 && components <= 3);
  for ([[maybe_unused]] const Transfer& field : fields)
    assert(field.structure.size() == structure_nodes_ * c);
  if (matching()) {
    for (const Transfer& field : fields) copy(field, c);
    return {};
  }
  const std::size_t size = c * static_cast<std::size_t>(merged_.count);
  work_.resize(fields.size() * size);
  for (std::size_t f = 0; f < fields.size(); ++f) multiply(fields[f], c, work_.data() + f * size);
  DROGUE_TRY(M_.solve(work_, work_, components * static_cast<int>(fields.size())));
  for (std::size_t f = 0; f < fields.size(); ++f) spread(work_.data() + f * size, fields[f], c);
  return {};
}

} // namespace drogue::projection
