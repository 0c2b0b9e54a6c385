// SPDX-License-Identifier: GPL-3.0-or-later
//
// Static inflation of the T-10 of [stein2001] from its flat pattern on the paper's two meshes. References for
// shape, stress and tension: an independent program on meshes of the same subdivision whose lines meet the
// confluence points half a gore further round.
#include <gtest/gtest.h>

#include "structure_solver/fields.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/t10_balance.hpp"

namespace drogue::structure {
namespace {

using drogue::test::verify;
using drogue::test::verify_relative;

struct Inflated {
  double equations = 0, unbalance = 0, diameter = 0, crown_height = 0;
  double largest_stress = 0, smallest_stress = 0, slack_fraction = 0;
  double suspension_tension = 0, radial_tension = 0, vent_tension = 0;
  double line_force = 0, pressure_force = 0; // after polishing
};

double largest_tension(const Model& model, const State& state, const std::string& group) {
  double largest = 0;
  for (const AnyBatch& any : model.batches) {
    const auto* batch = std::get_if<Batch<Line>>(&any);
    if (!batch || batch->group != group) continue;
    for (std::size_t e = 0; e < batch->count(); ++e) {
      Line::Positions x;
      for (int a = 0; a < 2; ++a) x.col(a) = test::place(model, state, batch->element(e)[a]);
      largest = std::max(largest, Line::tension(batch->reference[e], batch->material, x));
    }
  }
  return largest;
}

Inflated inflate(bool compatible) {
  config::Report report;
  Case c = drogue::test::t10_inflation(compatible, 1, 2.5e-3, report);
  EXPECT_TRUE(c.model) << report.lines().front();
  const State state = test::inflate(c);
  const Model& model = *c.model;
  Inflated r;
  for (const std::uint8_t held : model.held) r.equations += 1 - held;
  Integrator integrator(model, c.integrator_options(), state);
  r.unbalance = integrator.balance().unbalance;
  for (const std::int32_t node : model.mesh.nodes_of("canopy")) {
    const Eigen::Vector3d x = test::place(model, state, node);
    r.diameter = std::max(r.diameter, 2 * std::hypot(x(0), x(1)));
  }
  double skirt = 0;
  const auto edge = model.mesh.nodes_of("skirt_edge");
  for (const std::int32_t node : edge)
    skirt += test::place(model, state, node)(2) / static_cast<double>(edge.size());
  r.crown_height = test::place(model, state, model.mesh.nodes_of("apex").front())(2) - skirt;
  const StressFields stress = stress_fields(model, state.u, state.time);
  r.largest_stress = stress.max_stress;
  r.smallest_stress = stress.min_stress;
  r.slack_fraction = stress.slack_fraction;
  r.suspension_tension = largest_tension(model, state, "suspension_lines");
  r.radial_tension = largest_tension(model, state, "radials");
  r.vent_tension = largest_tension(model, state, "vent_lines");
  const State exact = test::polish(c, state);
  r.line_force = test::vertical_line_force(model, exact);
  r.pressure_force = 0.5 * test::projected_area(model, exact);
  return r;
}

struct Expected {
  double equations, diameter, crown_height, largest_stress, tension, line_force;
};

void check(const std::string& name, const Inflated& r, const Expected& e) {
  verify(name, "equations", r.equations, e.equations, 0);
  verify(name, "unbalance", r.unbalance, 0, 2.5e-3);
  verify_relative(name, "diameter", r.diameter, e.diameter, 5e-3);
  verify_relative(name, "crown_height", r.crown_height, e.crown_height, 0.01);
  verify_relative(name, "canopy_largest_principal_stress", r.largest_stress, e.largest_stress, 0.07);
  verify(name, "slack_fraction", r.slack_fraction, 0, 0);
  verify_relative(name, "suspension_lines_largest_tension", r.suspension_tension, e.tension, 0.05);
  verify_relative(name, "vertical_line_force", r.line_force, e.line_force, 5e-3);
  verify_relative(name, "vertical_line_force_over_pressure_force", r.line_force / r.pressure_force, 1, 1e-6);
}

TEST(T10, BothMeshesOfThePaper) {
  const Inflated incompatible = inflate(false), compatible = inflate(true);
  check("t10/incompatible", incompatible, {10713, 29.17, 11.62, 37060, 10.84, 282.84});
  verify_relative("t10/incompatible", "canopy_smallest_principal_stress", incompatible.smallest_stress, -5920,
                  0.05);
  check("t10/compatible", compatible, {27543, 28.89, 11.66, 42310, 10.79, 281.09});
  verify_relative("t10/compatible", "diameter_as_incompatible", compatible.diameter, incompatible.diameter,
                  0.03);
  // No reference for the other lines but the other mesh.
  verify_relative("t10/compatible", "radials_largest_tension_as_incompatible", compatible.radial_tension,
                  incompatible.radial_tension, 0.1);
  verify_relative("t10/compatible", "vent_lines_largest_tension_as_incompatible", compatible.vent_tension,
                  incompatible.vent_tension, 0.1);
}

} // namespace
} // namespace drogue::structure
