// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <utility>

#include "parachute_mesher/structure_mesh.hpp"
#include "structure_solver/case.hpp"

/// The T-10 of [stein2001] in memory, as configs/t10 describes it (feet, slugs, seconds, pounds).
namespace drogue::test {

inline const parachute::Canopy t10_canopy{.diameter = 35, .vent_ratio = 0.1, .skirt_ratio = 0.1, .gores = 30};

/// `refine` multiplies the elements of the lines.
inline mesh::Mesh t10_mesh(bool quadratic, const parachute::Subdivision& rows, int refine) {
  const parachute::Rigging rigging{.line_length = 29.4,
                                   .line_elements = 10 * refine,
                                   .vent_elements = 3 * refine,
                                   .confluence_distance = 2.3};
  return parachute::structure_mesh(t10_canopy, rigging,
                                   {.file = {},
                                    .element = quadratic ? mesh::ElementKind::quad9 : mesh::ElementKind::tri3,
                                    .rows = parachute::cloth_rows(t10_canopy, rows)});
}

/// The paper's two meshes; `refine` multiplies the elements along every edge.
inline mesh::Mesh t10_mesh(bool compatible, int refine = 1) {
  if (compatible)
    return t10_mesh(false,
                    {.main_rows = 42 * refine,
                     .skirt_rows = 9 * refine,
                     .across_vent = refine,
                     .across_seam = 8 * refine,
                     .across_skirt = 6 * refine,
                     .across_exponent = 0.584},
                    refine);
  return t10_mesh(true,
                  {.main_rows = 11 * refine,
                   .skirt_rows = 2 * refine,
                   .across_vent = 2 * refine,
                   .across_seam = 2 * refine,
                   .across_skirt = 2 * refine},
                  refine);
}

/// Inflation from the flat pattern under 0.5 lb/ft2, confluence points fixed, no gravity.
/// @param unbalance of the forces, relative to the load, at which to stop
inline structure::Settings t10_settings(int refine, double unbalance) {
  using namespace structure;
  Settings s;
  const LineMaterial line{1e-4, 6.0, 4.32e6, 0, StrainMeasure::green, true};
  s.membranes = {{"canopy", {1e-4, 6.0, 2e5, 0.3, 0}}};
  s.cables = {{"suspension_lines", line, 2.94 / refine}, {"radials", line, {}}, {"vent_lines", line, {}}};
  s.supports = {{"confluence", {true, true, true}, {}}};
  s.pressures = {{"canopy", std::move(*config::Expression::parse("0.5"))}};
  s.time.mode = TimeMode::static_by_damped_dynamics;
  s.time.step = 0.005;
  s.time.rho_infinity = 0;
  s.time.mass_damping = 20;
  s.time.unbalance = unbalance;
  s.newton.displacement_tolerance = 1e-5;
  s.newton.max_iterations = 12;
  s.output.field_interval = 0;
  return s;
}

/// The case at rest in the flat pattern. Without a model if it has errors, which `report` tells.
inline structure::Case t10_inflation(bool compatible, int refine, double unbalance, config::Report& report) {
  structure::Case c;
  c.settings = t10_settings(refine, unbalance);
  auto model = structure::build_model(c.settings, t10_mesh(compatible, refine), report);
  if (!model) return c;
  c.model = std::make_unique<const structure::Model>(std::move(*model));
  c.start = structure::rest_state(*c.model);
  return c;
}

} // namespace drogue::test
