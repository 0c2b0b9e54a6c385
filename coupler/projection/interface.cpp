// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/interface.hpp"

#include "coupler/projection/surface_integrals.hpp"

namespace drogue::projection {
namespace {

constexpr int max_refinement = 4;

/// How the fluid covers the structure's elements.
struct Coverage {
  double dry_area = 0;  ///< share of the area
  bool too_few = false; ///< a wet element has fewer points than nodes
};

Coverage coverage(const InterfaceQuadrature& quadrature, const Surface& structure) {
  Coverage result;
  double dry = 0, total = 0;
  const Elements elements(structure);
  for (std::int32_t e = 0; e < elements.count(); ++e) {
    const auto nodes = elements.nodes(e);
    const double area = element_mass(elements.kind(e), gather(nodes, structure.reference)).area;
    const auto i = static_cast<std::size_t>(e);
    total += area;
    if (quadrature.area_on()[i] < dry_share * area)
      dry += area;
    else if (static_cast<std::size_t>(quadrature.points_on()[i]) < nodes.size())
      result.too_few = true;
  }
  result.dry_area = dry / total;
  return result;
}

Result<InterfaceQuadrature> fine_enough(const Surface& structure, const Surface& fluid,
                                        const Settings& settings) {
  for (int refine = 1;; refine *= 2) {
    auto quadrature = InterfaceQuadrature::create(structure, fluid, settings, refine);
    if (!quadrature) return quadrature;
    const Coverage covered = coverage(*quadrature, structure);
    quadrature->report().dry_area = covered.dry_area;
    if (!covered.too_few || refine >= max_refinement) return quadrature;
  }
}

} // namespace

Result<Interface> make_interface(Surface structure, Surface fluid, const Settings& settings) {
  if (!(settings.largest_gap > 0))
    return config_error("projection.largest_gap = {}: must be above 0", settings.largest_gap);
  if (settings.quadrature_order < 1 || settings.quadrature_order > 8)
    return config_error("projection.quadrature_order = {}: must be 1 to 8", settings.quadrature_order);
  DROGUE_TRY(complete(structure));
  DROGUE_TRY(complete(fluid));
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

} // namespace drogue::projection
