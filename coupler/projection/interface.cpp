// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/interface.hpp"

#include <cmath>

#include "coupler/projection/surface_integrals.hpp"

namespace drogue::projection {
namespace {

constexpr int max_refinements = 2;

/// How the fluid covers the structure's elements.
struct Coverage {
  double dry_area = 0;       ///< share of the area
  bool too_few = false;      ///< a wet element has fewer points than nodes
  std::vector<char> starved; ///< {structure nodes}: 1 on such elements
};

Coverage coverage(const InterfaceQuadrature& quadrature, const Surface& structure) {
  Coverage result;
  result.starved.assign(structure.node_count(), 0);
  double dry = 0, total = 0;
  const Elements elements(structure);
  for (std::int32_t e = 0; e < elements.count(); ++e) {
    const auto nodes = elements.nodes(e);
    const double area = element_mass(elements.kind(e), gather(nodes, structure.reference)).area;
    const auto i = static_cast<std::size_t>(e);
    total += area;
    if (quadrature.area_on()[i] < dry_share * area) dry += area;
    if (static_cast<std::size_t>(quadrature.points_on()[i]) >= nodes.size()) continue;
    if (quadrature.points_on()[i] == 0) continue;
    result.too_few = true;
    for (const std::int32_t node : nodes) result.starved[static_cast<std::size_t>(node)] = 1;
  }
  result.dry_area = dry / total;
  return result;
}

/// Doubles the subdivisions of the fluid elements around starved structure elements.
void refine_around(const Coverage& covered, const InterfaceQuadrature& quadrature, std::vector<int>& refine) {
  for (std::size_t e = 0; e < refine.size(); ++e) {
    const auto& element = quadrature.elements()[e];
    const auto points = static_cast<std::int64_t>(quadrature.rule(element).weights.size());
    bool near = false;
    for (std::int64_t q = 0; q < points && !near; ++q)
      for (const std::int32_t node : quadrature.structure_nodes(element.first_point + q))
        near = near || covered.starved[static_cast<std::size_t>(node)] == 1;
    if (near) refine[e] *= 2;
  }
}

Result<InterfaceQuadrature> fine_enough(const Surface& structure, const Surface& fluid,
                                        const Settings& settings) {
  std::vector<int> refine(static_cast<std::size_t>(Elements(fluid).count()), 1);
  for (int round = 0;; ++round) {
    auto quadrature = InterfaceQuadrature::create(structure, fluid, settings, refine);
    if (!quadrature) return quadrature;
    const Coverage covered = coverage(*quadrature, structure);
    quadrature->report().dry_area = covered.dry_area;
    if (!covered.too_few || round == max_refinements) return quadrature;
    refine_around(covered, *quadrature, refine);
  }
}

} // namespace

Result<Interface> make_interface(Surface structure, Surface fluid, const Settings& settings) {
  if (!(settings.largest_gap > 0))
    return config_error("projection.largest_gap = {}: must be above 0", settings.largest_gap);
  if (settings.quadrature_order < 1 || settings.quadrature_order > 8)
    return config_error("projection.quadrature_order = {}: must be 1 to 8", settings.quadrature_order);
  if (!(settings.largest_unmatched_area >= 0 && settings.largest_unmatched_area <= 1))
    return config_error("projection.largest_unmatched_area = {}: must be 0 to 1",
                        settings.largest_unmatched_area);
  if (!(settings.largest_normal_angle > 0 && settings.largest_normal_angle <= 90))
    return config_error("projection.largest_normal_angle = {}: must be above 0 and at most 90 degrees",
                        settings.largest_normal_angle);
  DROGUE_TRY(complete(structure));
  DROGUE_TRY(complete(fluid));
  if (structure.dimension() != fluid.dimension())
    return config_error("the {} surface is made of {}, the {} surface of {}: both must be of the same kind",
                        structure.name, structure.dimension() == 1 ? "lines" : "faces", fluid.name,
                        fluid.dimension() == 1 ? "lines" : "faces");
  auto quadrature = fine_enough(structure, fluid, settings);
  if (!quadrature) return quadrature.error();
  auto field = FieldProjection::create(*quadrature, structure, fluid);
  if (!field) return field.error();
  auto load = LoadTransfer::create(*quadrature, structure, fluid);
  if (!load) return load.error();
  MatchReport report = quadrature->report();
  report.matching = field->matching();
  return Interface{std::move(structure), std::move(fluid), std::move(*field), std::move(*load), report};
}

double projection_defect(const Interface& interface, std::span<const double> structure,
                         std::span<const double> fluid) noexcept {
  if (interface.field.matching()) return 0;
  const InterfaceQuadrature& quadrature = interface.load.quadrature();
  double missed = 0, whole = 0;
  for (const auto& element : quadrature.elements()) {
    const auto& rule = quadrature.rule(element);
    const NodeMatrix X = gather(element.nodes, interface.fluid.reference), d_f = gather(element.nodes, fluid);
    for (std::size_t q = 0; q < rule.weights.size(); ++q) {
      const auto point = element.first_point + static_cast<std::int64_t>(q);
      const auto nodes = quadrature.structure_nodes(point);
      const auto N = quadrature.structure_N(point);
      Eigen::Vector3d d_s = Eigen::Vector3d::Zero();
      for (std::size_t a = 0; a < nodes.size(); ++a)
        d_s += N[a] * Eigen::Map<const Eigen::Vector3d>(structure.data() + 3 * nodes[a]);
      const ElementShape& shape = rule.shapes[q];
      const double da = rule.weights[q] * area_vector(shape, X).norm();
      missed += da * (combine(shape.N, shape.nodes, d_f) - d_s).squaredNorm();
      whole += da * d_s.squaredNorm();
    }
  }
  return whole > 0 ? std::sqrt(missed / whole) : 0;
}

} // namespace drogue::projection
