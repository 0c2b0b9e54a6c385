// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/field_projection.hpp"

#include <algorithm>
#include <cassert>
#include <set>

#include "coupler/projection/element_matrix.hpp"
#include "coupler/projection/projection_kernels.hpp"

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

/// The unknowns of each element.
class ElementUnknowns {
 public:
  ElementUnknowns(const Elements& elements, const std::vector<std::int32_t>& unknown) {
    for (std::int32_t e = 0; e < elements.count(); ++e) {
      for (const std::int32_t node : elements.nodes(e))
        unknowns_.push_back(unknown[static_cast<std::size_t>(node)]);
      first_.push_back(unknowns_.size());
    }
  }
  std::span<const std::int32_t> operator()(std::int32_t e) const {
    const auto i = static_cast<std::size_t>(e);
    return {unknowns_.data() + first_[i], first_[i + 1] - first_[i]};
  }

 private:
  std::vector<std::int32_t> unknowns_;
  std::vector<std::size_t> first_{0};
};

/// The area of a flat element over that of its parent domain.
double flat_scale(mesh::ElementKind kind, std::span<const std::int32_t> nodes, const Surface& surface) {
  return area_vector(element_shape(kind, 0, 0), gather(nodes, surface.reference)).norm();
}

/// int N_b N_c dA over the reference area by the points of a curved element, the same as those of its
/// products with the structure.
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

Result<FieldProjection> FieldProjection::begin(const Surface& structure, const Surface& fluid) {
  FieldProjection made;
  made.structure_nodes_ = structure.node_count();
  made.copy_from_ = matching_nodes(structure, fluid);
  if (made.matching()) return made;
  Merged merged = merge_coincident(fluid.material, same_place * extent(structure.material));
  made.unknown_ = std::move(merged.group);
  made.unknowns_ = merged.count;
  const bool flat = std::all_of(fluid.blocks.begin(), fluid.blocks.end(),
                                [](const mesh::ElementBlock& block) { return is_flat(block.kind); });
  if (flat) DROGUE_TRY(made.factor_mass(fluid, nullptr));
  return made;
}

/// M_f and its factor, in whose order the unknowns are then.
/// @param quadrature may be null where all elements are flat
Result<void> FieldProjection::factor_mass(const Surface& fluid, const InterfaceQuadrature* quadrature) {
  const Elements elements(fluid);
  std::vector<std::size_t> first;
  std::vector<double> curved, scale;
  for (std::int32_t e = 0; e < elements.count(); ++e) {
    const bool flat = is_flat(elements.kind(e));
    first.push_back(curved.size());
    scale.push_back(flat ? flat_scale(elements.kind(e), elements.nodes(e), fluid) : 1);
    if (!flat)
      add_curved_mass(*quadrature, quadrature->elements()[static_cast<std::size_t>(e)], fluid, curved);
  }
  const ElementUnknowns rows(elements, unknown_);
  const auto mass = [&](std::int32_t e) {
    const auto i = static_cast<std::size_t>(e);
    const bool flat = is_flat(elements.kind(e));
    return ElementPart{rows(e),
                       rows(e),
                       flat ? flat_mass(elements.kind(e)).data() : curved.data() + first[i],
                       flat ? 3 : elements.nodes(e).size(),
                       1,
                       scale[i]};
  };
  const Adjacency around = elements_around(unknowns_, elements.count(), rows);
  auto factored = M_.factor(upper_triangle(sum_elements(unknowns_, unknowns_, around, mass, true)));
  if (!factored) return factored.error();
  if (!*factored)
    return config_error("the mass matrix of the {} surface is singular: raise projection.quadrature_order",
                        fluid.name);
  std::vector<std::int32_t> place(static_cast<std::size_t>(unknowns_));
  for (std::int32_t row = 0; const int equation : M_.order())
    place[static_cast<std::size_t>(equation)] = row++;
  for (std::int32_t& i : unknown_) i = place[static_cast<std::size_t>(i)];
  is_factored_ = true;
  return {};
}

Result<void> FieldProjection::end(const InterfaceQuadrature& quadrature, const Surface& structure,
                                  const Surface& fluid) {
  if (matching()) return {};
  if (!is_factored_) DROGUE_TRY(factor_mass(fluid, &quadrature));
  const ElementUnknowns rows(quadrature.fluid_elements(), unknown_);
  std::vector<double> scale;
  for (const auto& element : quadrature.elements())
    scale.push_back(element.rule < 0 ? flat_scale(element.kind, element.nodes, fluid) : 1);
  const auto cross = [&](std::int32_t e) {
    const auto& element = quadrature.elements()[static_cast<std::size_t>(e)];
    return ElementPart{rows(e),
                       quadrature.block_nodes(element),
                       quadrature.block(element),
                       1,
                       element.nodes.size(),
                       scale[static_cast<std::size_t>(e)]};
  };
  const Adjacency around = elements_around(unknowns_, quadrature.fluid_elements().count(), rows);
  B_ = sum_elements(unknowns_, static_cast<std::int32_t>(structure.node_count()), around, cross);
  return {};
}

void FieldProjection::copy(const Transfer& field, std::size_t c) const {
  for (std::size_t i = 0; i < copy_from_.size(); ++i)
    for (std::size_t k = 0; k < c; ++k)
      field.fluid[i * c + k] = field.structure[static_cast<std::size_t>(copy_from_[i]) * c + k];
}

/// One or two fields, four values of a row each. They are taken relative to the first node: rounding is that
/// of the differences, and none is left of constants.
void FieldProjection::project(std::span<const Transfer> fields, std::size_t c) {
  const std::size_t lanes = fields.size() == 1 ? 4 : 8;
  const auto rows = static_cast<std::size_t>(B_.rows());
  source_.assign(structure_nodes_ * lanes, 0.0);
  solution_.resize(rows * lanes);
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const double* given = fields[f].structure.data();
    for (std::size_t i = 0; i < structure_nodes_; ++i) {
      double* row = source_.data() + i * lanes + 4 * f;
      for (std::size_t k = 0; k < c; ++k) row[k] = given[i * c + k] - given[k];
    }
  }
  const RowMatrix B{static_cast<std::int32_t>(rows), B_.outerIndexPtr(), B_.innerIndexPtr(), B_.valuePtr()};
  const ProjectionKernels& kernels = projection_kernels();
  (lanes == 4 ? kernels.multiply_4 : kernels.multiply_8)(B, source_.data(), solution_.data());
  M_.solve_rows(solution_, static_cast<int>(lanes));
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const double* given = fields[f].structure.data();
    for (std::size_t i = 0; i < unknown_.size(); ++i) {
      const double* row = solution_.data() + static_cast<std::size_t>(unknown_[i]) * lanes + 4 * f;
      for (std::size_t k = 0; k < c; ++k) fields[f].fluid[i * c + k] = given[k] + row[k];
    }
  }
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
  for (std::size_t f = 0; f < fields.size(); f += 2)
    project(fields.subspan(f, std::min<std::size_t>(2, fields.size() - f)), c);
  return {};
}

} // namespace drogue::projection
