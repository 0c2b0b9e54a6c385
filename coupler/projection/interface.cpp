// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/interface.hpp"

#include <cmath>

namespace drogue::projection {

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
  auto quadrature = InterfaceQuadrature::create(structure, fluid, settings);
  if (!quadrature) return quadrature.error();
  auto field = FieldProjection::create(*quadrature, structure, fluid);
  if (!field) return field.error();
  MatchReport report = quadrature->report();
  auto load = LoadTransfer::create(std::move(*quadrature), structure, fluid, settings.recover_traction);
  if (!load) return load.error();
  report.matching = field->matching();
  return Interface{std::move(structure), std::move(fluid), std::move(*field), std::move(*load), report};
}

double projection_defect(const Interface& interface, std::span<const double> structure,
                         std::span<const double> fluid) noexcept {
  if (interface.field.matching()) return 0;
  const InterfaceQuadrature& quadrature = interface.load.quadrature();
  const auto value = [](const Elements& elements, std::int32_t e, const std::array<double, 2>& at,
                        std::span<const double> d) {
    const ElementShape shape = element_shape(elements.kind(e), at[0], at[1]);
    return combine(shape.N, shape.nodes, gather(elements.nodes(e), d));
  };
  double missed = 0, whole = 0;
  for (const InterfaceQuadrature::Sample& s : quadrature.samples()) {
    const Eigen::Vector3d d_s = value(quadrature.structure_elements(), s.structure_element, s.on_structure,
                                      structure),
                          d_f = value(quadrature.fluid_elements(), s.fluid_element, s.on_fluid, fluid);
    missed += s.weight * (d_f - d_s).squaredNorm();
    whole += s.weight * d_s.squaredNorm();
  }
  return whole > 0 ? std::sqrt(missed / whole) : 0;
}

} // namespace drogue::projection
