// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/settings.hpp"

#include <fmt/format.h>

#include "drogue/v1/structure.pb.h"

namespace drogue::structure {
namespace {

/// Texts that do not parse were reported by config::load already; zero stands in for them.
config::Expression expression(const std::string& text) {
  auto parsed = config::Expression::parse(text);
  return parsed ? std::move(*parsed) : config::Expression();
}

config::VectorExpression expression(const v1::VectorExpression& message) {
  return {expression(message.x()), expression(message.y()), expression(message.z())};
}

MembraneSettings membrane(const v1::MembraneGroup& m) {
  return {m.group(),
          {.thickness = m.thickness(),
           .density = m.density(),
           .youngs_modulus = m.youngs_modulus(),
           .poisson_ratio = m.poisson_ratio(),
           .prestress = m.prestress(),
           .wrinkling = m.wrinkling() == v1::TENSION_FIELD ? Wrinkling::tension_field : Wrinkling::none,
           .slack_stiffness = m.slack_stiffness()}};
}

LineSettings line(const v1::LineGroup& m, bool tension_only) {
  LineSettings line;
  line.group = m.group();
  line.material = {m.area(),
                   m.density(),
                   m.youngs_modulus(),
                   m.prestress(),
                   m.strain() == v1::ENGINEERING ? StrainMeasure::engineering : StrainMeasure::green,
                   tension_only,
                   m.slack_strain()};
  if (m.has_natural_length()) line.natural_length = m.natural_length();
  return line;
}

SupportSettings support(const v1::Support& m, const std::string& where, config::Report& report) {
  SupportSettings s;
  s.group = m.group();
  for (const char c : m.components()) {
    if (c < 'x' || c > 'z')
      report.error(where, fmt::format("components is \"{}\"; only the letters x, y and z may stand in it",
                                      m.components()));
    else
      s.held[static_cast<std::size_t>(c - 'x')] = true;
  }
  if (m.components().empty())
    report.error(where, "components is empty; give any of x, y, z, for example \"xyz\"");
  s.displacement = expression(m.displacement());
  return s;
}

DragSettings drag(const v1::PointDrag& m) {
  return {m.group(), 0.5 * m.air_density() * m.drag_coefficient() * m.area(), expression(m.air_velocity()),
          false};
}
DragSettings drag(const v1::LineDrag& m) {
  return {m.group(), 0.5 * m.air_density() * m.drag_coefficient() * m.diameter(),
          expression(m.air_velocity()), m.cross_flow()};
}

NaturalLengthSettings natural_length(const v1::NaturalLength& m, const std::string& where,
                                     config::Report& report) {
  NaturalLengthSettings s{m.group(), {}};
  for (const auto& point : m.point()) {
    if (!s.schedule.points.empty() && !(point.time() > s.schedule.points.back().time))
      report.error(where, fmt::format("the point at time {} follows one at time {}; times must increase",
                                      point.time(), s.schedule.points.back().time));
    s.schedule.points.push_back({point.time(), point.factor()});
  }
  s.schedule.smooth = m.ramp() == v1::NaturalLength::SMOOTH;
  s.schedule.factor = expression(m.factor());
  return s;
}

TimeSettings time(const v1::StructureTime& m) {
  TimeSettings t;
  switch (m.mode()) {
  case v1::StructureTime::DYNAMIC:
    t.mode = TimeMode::dynamic;
    break;
  case v1::StructureTime::STATIC_BY_DAMPED_DYNAMICS:
    t.mode = TimeMode::static_by_damped_dynamics;
    break;
  case v1::StructureTime::STATIC_BY_NEWTON:
    t.mode = TimeMode::static_by_newton;
    break;
  }
  switch (m.scheme()) {
  case v1::StructureTime::GENERALISED_ALPHA:
    t.scheme = TimeScheme::generalised_alpha;
    break;
  case v1::StructureTime::HHT:
    t.scheme = TimeScheme::hht;
    break;
  case v1::StructureTime::NEWMARK:
    t.scheme = TimeScheme::newmark;
    break;
  }
  t.hht_alpha = m.hht_alpha();
  t.newmark_beta = m.newmark_beta();
  t.newmark_gamma = m.newmark_gamma();
  t.stiffness_damping = m.stiffness_damping();
  t.max_halvings = m.max_halvings();
  t.ramp_loads = m.ramp_loads();
  t.step = m.step();
  t.steps = m.steps();
  t.rho_infinity = m.rho_infinity();
  t.mass_damping = m.mass_damping();
  t.largest_step = m.largest_step();
  t.largest_time = m.largest_time();
  t.unbalance = m.unbalance();
  t.balanced_start = m.balanced_start();
  return t;
}

} // namespace

Settings load_settings(const std::filesystem::path& file, config::Report& report) {
  v1::StructureConfig m;
  Settings s;
  s.source = config::load(file, m, report);
  s.mesh = s.source.resolve(m.mesh());
  if (m.has_initial_state()) s.initial_state = s.source.resolve(m.initial_state());
  s.initial_at_rest = m.initial_at_rest();
  if (m.has_final_state()) s.final_state = m.final_state();
  for (const auto& g : m.membrane()) s.membranes.push_back(membrane(g));
  s.plane = m.plane();
  for (const auto& g : m.solid())
    s.solids.push_back({g.group(), {g.density(), g.youngs_modulus(), g.poisson_ratio()}});
  for (const auto& g : m.cable()) s.cables.push_back(line(g, true));
  for (const auto& g : m.truss()) s.trusses.push_back(line(g, false));
  for (const auto& g : m.mass()) s.masses.push_back({g.group(), g.mass()});
  s.ignored_groups.assign(m.ignore_group().begin(), m.ignore_group().end());
  for (int i = 0; i < m.support_size(); ++i)
    s.supports.push_back(
        support(m.support(i), s.source.where(fmt::format("support[{}].components", i)), report));
  for (const auto& g : m.pressure()) s.pressures.push_back({g.group(), expression(g.value())});
  for (const auto& g : m.traction()) s.tractions.push_back({g.group(), expression(g.value())});
  for (const auto& g : m.force()) s.forces.push_back({g.group(), expression(g.value())});
  s.gravity = expression(m.gravity());
  for (const auto& g : m.point_drag()) s.point_drag.push_back(drag(g));
  for (const auto& g : m.line_drag()) s.line_drag.push_back(drag(g));
  for (int i = 0; i < m.natural_length_size(); ++i)
    s.natural_lengths.push_back(natural_length(
        m.natural_length(i), s.source.where(fmt::format("natural_length[{}].point", i)), report));
  if (m.has_initial_velocity()) s.initial_velocity = expression(m.initial_velocity());
  s.time = time(m.time());
  s.newton = {m.newton().displacement_tolerance(), m.newton().residual_tolerance(),
              m.newton().max_iterations(), m.newton().iterations_per_coupling(), m.newton().load_stiffness()};
  s.interface = m.interface();
  s.parts = m.subcycling().parts();
  s.quadratic_inputs = m.subcycling().interpolation() == v1::Subcycling::QUADRATIC;
  if (s.parts > 1 && s.newton.iterations_per_coupling > 0)
    report.error(s.source.where("subcycling.parts"),
                 "subcycling does not go with newton.iterations_per_coupling: every part is iterated to the "
                 "tolerance; leave that out");
  s.threads = m.threads();
  s.output = {m.output().directory(), m.output().field_interval(), m.output().series_interval()};
  for (const auto& p : m.probe()) s.probes.push_back({p.name(), {p.x(), p.y(), p.z()}});
  for (const auto& f : m.line_force()) s.line_forces.push_back({f.name(), f.group(), f.at()});
  return s;
}

} // namespace drogue::structure
