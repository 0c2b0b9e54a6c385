// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/case.hpp"

#include <cmath>

#include <fmt/core.h>

#include "common/mesh/msh.hpp"
#include "structure_solver/group_roles.hpp"
#include "structure_solver/line_forces.hpp"
#include "structure_solver/load_values.hpp"
#include "structure_solver/probes.hpp"
#include "structure_solver/state_io.hpp"

namespace drogue::structure {
namespace {

GeneralisedAlpha scheme(const TimeSettings& time) {
  switch (time.scheme) {
  case TimeScheme::hht:
    return GeneralisedAlpha::hht(time.hht_alpha);
  case TimeScheme::newmark:
    return GeneralisedAlpha::newmark(time.newmark_beta, time.newmark_gamma);
  case TimeScheme::generalised_alpha:
    break;
  }
  return GeneralisedAlpha::from_rho(time.rho_infinity);
}

/// The velocity of the config, at the positions of the start.
Result<void> set_velocity(const config::VectorExpression& velocity, const Model& model, State& state) {
  for (std::size_t i = 0; i < state.v.size(); ++i) {
    const std::size_t first = i - i % 3;
    const auto x = [&](std::size_t c) { return model.mesh.points[first + c] + state.u[first + c]; };
    state.v[i] = velocity[i % 3](x(0), x(1), x(2), state.time);
    if (!std::isfinite(state.v[i]))
      return config_error("initial_velocity: \"{}\" is {} at x = {}, y = {}, z = {}", velocity[i % 3].text(),
                          state.v[i], x(0), x(1), x(2));
  }
  return {};
}

/// The state of the config's initial_state; otherwise a fresh start that moves as initial_velocity and the
/// supports say.
Result<State> start_state(const Settings& settings, const Model& model) {
  State fresh = rest_state(model);
  if (settings.initial_state) {
    auto state = read_state(*settings.initial_state, model);
    if (!state || !settings.initial_at_rest) return state;
    fresh.u = std::move(state->u);
  }
  if (settings.initial_velocity) DROGUE_TRY(set_velocity(*settings.initial_velocity, model, fresh));
  if (settings.time.mode == TimeMode::static_by_newton) return fresh;
  const auto held = held_motion(model, fresh.time, held_difference * settings.time.step);
  if (!held) return held.error();
  for (const HeldMotion& motion : *held) {
    fresh.u[motion.equation] = motion.u;
    fresh.v[motion.equation] = motion.v;
    fresh.a[motion.equation] = motion.a;
  }
  return fresh;
}

/// What only a state tells.
void check_start(const Case& c, config::Report& report) {
  const Settings& s = c.settings;
  for (const LoadFault& fault : load_faults(*c.model, c.start.time))
    report.error(s.source.where(fault.field), fault.text);
  if (s.initial_velocity && s.initial_state && !s.initial_at_rest)
    report.error(s.source.where("initial_velocity"), "the run continues with the velocity of initial_state; "
                                                     "leave one of the two out, or set initial_at_rest");
}

void check_participant(const Settings& s, config::Report& report) {
  const config::Source& source = s.source;
  if (s.interface.empty())
    report.error(source.where("interface"),
                 "a participant needs interface: the group of surfaces that meets the fluid");
  if (s.time.mode != TimeMode::dynamic)
    report.error(source.where("time.mode"),
                 "a participant needs time.mode: DYNAMIC; static equilibrium is for a stand-alone run");
  if (s.final_state)
    report.error(source.where("final_state"),
                 "final_state is ignored by a participant, whose states the coupler keeps: leave it out");
}

} // namespace

Integrator::Options Case::integrator_options() const {
  const TimeSettings& time = settings.time;
  Integrator::Options options;
  options.scheme = scheme(time);
  options.mass_damping = time.mass_damping;
  options.stiffness_damping = time.stiffness_damping;
  options.newton = settings.newton;
  options.threads = settings.threads;
  options.statics = time.mode == TimeMode::static_by_newton;
  if (options.statics && time.ramp_loads && time.steps > 0)
    options.ramp = {start.time, start.time + time.steps * time.step};
  return options;
}

Result<Case> load_case(const std::filesystem::path& file, Role role) {
  config::Report report;
  Case c;
  c.settings = load_settings(file, report);
  if (!c.settings.source.parsed()) return report.as_error();
  if (role == Role::participant) check_participant(c.settings, report);
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(c.settings.mesh, ignored))
    return report.as_error(); // reported by the schema's rule
  auto mesh = mesh::read_msh(c.settings.mesh);
  if (!mesh) {
    report.error(c.settings.source.where("mesh"), mesh.error().message);
    return report.as_error();
  }
  check_group_roles(c.settings, report);
  auto model = build_model(c.settings, std::move(*mesh), report);
  if (!model) return report.as_error();
  check_probes(c.settings, *model, report);
  (void)line_forces(c.settings, *model, report);
  c.model = std::make_unique<const Model>(std::move(*model));
  if (!c.settings.initial_state || std::filesystem::is_regular_file(*c.settings.initial_state, ignored)) {
    auto start = start_state(c.settings, *c.model);
    if (start)
      c.start = std::move(*start);
    else
      report.error(c.settings.source.where(c.settings.initial_state ? "initial_state" : "mesh"),
                   start.error().message);
    if (start) check_start(c, report);
  }
  if (!report.ok()) return report.as_error();
  return c;
}

Result<void> check_case(const std::filesystem::path& file, Role role) {
  const auto loaded = load_case(file, role);
  if (!loaded) return loaded.error();
  fmt::print("{}: ok\n", file.string());
  return {};
}

} // namespace drogue::structure
