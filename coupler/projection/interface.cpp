// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/interface.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/worker_pool.hpp"

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
  // The products of both surfaces, and beside them what the fluid's surface needs alone.
  auto quadrature = Result<InterfaceQuadrature>(InterfaceQuadrature());
  auto field = Result<FieldProjection>(FieldProjection());
  WorkerPool workers(std::min(default_threads(), 2));
  workers.run([&](int worker) {
    if (worker == 0) quadrature = InterfaceQuadrature::create(structure, fluid, settings);
    if (worker == workers.size() - 1) field = FieldProjection::begin(structure, fluid);
  });
  if (!quadrature) return quadrature.error();
  if (!field) return field.error();
  DROGUE_TRY(field->end(*quadrature, structure, fluid));
  MatchReport report = quadrature->report();
  auto load = LoadTransfer::create(std::move(*quadrature), structure, fluid, settings.recover_traction);
  if (!load) return load.error();
  report.matching = field->matching();
  return Interface{std::move(structure), std::move(fluid), std::move(*field), std::move(*load), report};
}

namespace {

using Weights = std::array<double, fem::max_surface_nodes>;

Weights weights(mesh::ElementKind kind, const std::array<double, 2>& at) {
  if (kind == mesh::ElementKind::tri3) return {1 - at[0] - at[1], at[0], at[1]};
  return element_shape(kind, at[0], at[1]).N;
}

Eigen::Vector3d value(std::span<const std::int32_t> nodes, const Weights& N, std::span<const double> d) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t a = 0; a < nodes.size(); ++a)
    sum += N[a] * Eigen::Map<const Eigen::Vector3d>(d.data() + 3 * static_cast<std::size_t>(nodes[a]));
  return sum;
}

} // namespace

void projection_defects(const Interface& interface, std::span<const ProjectedField> fields,
                        std::span<double> defects) noexcept {
  std::fill(defects.begin(), defects.end(), 0.0);
  if (interface.field.matching()) return;
  const InterfaceQuadrature& quadrature = interface.load.quadrature();
  const Elements &on_structure = quadrature.structure_elements(), &on_fluid = quadrature.fluid_elements();
  std::array<double, most_fields_at_once> missed{}, whole{};
  for (const InterfaceQuadrature::Sample& s : quadrature.samples()) {
    const Weights N_s = weights(on_structure.kind(s.structure_element), s.on_structure),
                  N_f = weights(on_fluid.kind(s.fluid_element), s.on_fluid);
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const Eigen::Vector3d d_s = value(on_structure.nodes(s.structure_element), N_s, fields[i].structure),
                            d_f = value(on_fluid.nodes(s.fluid_element), N_f, fields[i].fluid);
      missed[i] += s.weight * (d_f - d_s).squaredNorm();
      whole[i] += s.weight * d_s.squaredNorm();
    }
  }
  for (std::size_t i = 0; i < fields.size(); ++i)
    if (whole[i] > 0) defects[i] = std::sqrt(missed[i] / whole[i]);
}

} // namespace drogue::projection
