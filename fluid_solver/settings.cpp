// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/settings.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "drogue/v1/fluid.pb.h"

namespace drogue::fluid {
namespace {

/// Texts that do not parse were reported by config::load already; zero stands in for them.
config::Expression expression(const std::string& text) {
  auto parsed = config::Expression::parse(text);
  return parsed ? std::move(*parsed) : config::Expression();
}

config::VectorExpression expression(const v1::VectorExpression& message) {
  return {expression(message.x()), expression(message.y()), expression(message.z())};
}

std::array<bool, 3> components(const std::string& text, const std::string& where, config::Report& report) {
  std::array<bool, 3> held{};
  for (const char c : text) {
    if (c >= 'x' && c <= 'z')
      held[static_cast<std::size_t>(c - 'x')] = true;
    else
      report.error(where,
                   fmt::format("components is \"{}\"; only the letters x, y and z may stand in it", text));
  }
  if (text.empty()) report.error(where, "components is empty; give any of x, y, z, for example \"xyz\"");
  return held;
}

BoundarySettings boundary(const v1::FluidBoundary& m, const std::string& path, const config::Source& source,
                          config::Report& report) {
  BoundarySettings b;
  b.name = m.name();
  switch (m.condition_case()) {
  case v1::FluidBoundary::kVelocity:
    b.condition = Condition::velocity;
    b.value = expression(m.velocity());
    break;
  case v1::FluidBoundary::kNoSlip:
    b.condition = Condition::no_slip;
    b.components = components(m.no_slip().components(), source.where(path + ".no_slip.components"), report);
    break;
  case v1::FluidBoundary::kFreeSlip:
    b.condition = Condition::free_slip;
    b.slip_wall = m.free_slip().wall();
    break;
  case v1::FluidBoundary::kTractionFree:
    b.condition = Condition::traction_free;
    b.backflow = m.traction_free().backflow();
    break;
  case v1::FluidBoundary::kTraction:
    b.condition = Condition::traction;
    b.value = expression(m.traction());
    break;
  case v1::FluidBoundary::CONDITION_NOT_SET:
    report.error(source.where(path),
                 fmt::format("boundary \"{}\" has no condition; give one of velocity, no_slip, "
                             "free_slip, traction_free, traction",
                             m.name()));
    break;
  }
  return b;
}

void load_boundaries(const v1::FluidConfig& m, Settings& s, config::Report& report) {
  std::set<std::string> names;
  for (int i = 0; i < m.boundary_size(); ++i) {
    const std::string path = fmt::format("boundary[{}]", i);
    s.boundaries.push_back(boundary(m.boundary(i), path, s.source, report));
    if (!names.insert(m.boundary(i).name()).second)
      report.error(
          s.source.where(path + ".name"),
          fmt::format("boundary \"{}\" is given twice; name every boundary once", m.boundary(i).name()));
  }
  for (int i = 0; i < m.interface_size(); ++i) {
    s.interface.push_back(m.interface(i));
    const auto found = std::find_if(s.boundaries.begin(), s.boundaries.end(),
                                    [&](const BoundarySettings& b) { return b.name == m.interface(i); });
    if (found != s.boundaries.end() && found->condition != Condition::no_slip)
      report.error(
          s.source.where(fmt::format("interface[{}]", i)),
          fmt::format("interface \"{}\" must be a no_slip boundary: the structure moves it", m.interface(i)));
  }
}

void load_phases(const v1::FluidConfig& m, Settings& s, config::Report& report) {
  for (int i = 0; i < m.phase_size(); ++i) {
    const v1::FluidPhase& p = m.phase(i);
    PhaseSettings phase;
    phase.formulation =
        p.formulation() == v1::FluidPhase::DSD_SST ? Formulation::dsd_sst : Formulation::semi_discrete;
    phase.step = p.step();
    phase.steps = p.steps();
    phase.time_order = p.time_order();
    phase.time_points = p.time_points();
    phase.steady_tolerance = p.steady_tolerance();
    if (p.has_mesh_displacement()) phase.mesh_displacement = expression(p.mesh_displacement());
    if (phase.mesh_displacement && phase.formulation == Formulation::semi_discrete)
      report.error(s.source.where(fmt::format("phase[{}].mesh_displacement", i)),
                   "mesh_displacement needs formulation: DSD_SST; SEMI_DISCRETE keeps the mesh fixed");
    s.phases.push_back(std::move(phase));
  }
}

void load_forces(const v1::FluidConfig& m, Settings& s, config::Report& report) {
  for (int i = 0; i < m.force_size(); ++i) {
    const v1::ForceReport& f = m.force(i);
    if (f.has_reference_area() != f.has_reference_speed())
      report.error(
          s.source.where(fmt::format("force[{}]", i)),
          fmt::format("force \"{}\": give both reference_area and reference_speed, or neither", f.name()));
    const double speed = f.reference_speed();
    s.forces.push_back({f.name(),
                        {f.boundary().begin(), f.boundary().end()},
                        0.5 * s.density * speed * speed * f.reference_area(),
                        {f.moment_about().x(), f.moment_about().y(), f.moment_about().z()}});
  }
}

/// What only a stand-alone run uses: the coupler sets folder and steps.
std::vector<std::string> alone_only(const v1::FluidConfig& m) {
  std::vector<std::string> fields;
  if (m.output().has_directory()) fields.emplace_back("output.directory");
  for (int i = 0; i < m.phase_size(); ++i) {
    if (m.phase(i).has_step()) fields.push_back(fmt::format("phase[{}].step", i));
    if (m.phase(i).has_steps()) fields.push_back(fmt::format("phase[{}].steps", i));
  }
  return fields;
}

} // namespace

Settings load_settings(const std::filesystem::path& file, config::Report& report) {
  v1::FluidConfig m;
  Settings s;
  s.source = config::load(file, m, report);
  s.mesh = s.source.resolve(m.mesh());
  if (m.has_initial_state()) s.initial_state = s.source.resolve(m.initial_state());
  if (m.has_initial_state_mesh()) {
    s.initial_state_mesh = s.source.resolve(m.initial_state_mesh());
    if (!s.initial_state)
      report.error(s.source.where("initial_state_mesh"),
                   "initial_state_mesh is the mesh of an initial_state, and there is none");
  }
  if (m.has_final_state()) s.final_state = m.final_state();
  s.initial_velocity = expression(m.initial_velocity());
  s.initial_pressure = expression(m.initial_pressure());
  s.project_initial_flow = m.initial_flow() == v1::FluidConfig::PROJECTED;
  s.density = m.density();
  s.dynamic_viscosity = m.dynamic_viscosity();
  s.smagorinsky = m.smagorinsky();
  s.lsic = m.stabilisation().lsic();
  s.time_weight = m.stabilisation().time_weight();
  s.viscous_residual = m.stabilisation().viscous_residual();
  if (m.stabilisation().has_tau_step()) s.tau_step = m.stabilisation().tau_step();
  s.body_force = expression(m.body_force());
  load_phases(m, s, report);
  if (m.has_remesh()) s.remesh = {m.remesh().mean_ratio(), m.remesh().angle()};
  s.newton = {m.newton().residual_tolerance(),  m.newton().max_iterations(),
              m.newton().failure_tolerance(),   m.newton().iterations_per_coupling(),
              m.newton().jacobian_lag(),        m.newton().linearisation() == v1::FluidNewton::PICARD,
              m.newton().shortest_correction(), m.newton().max_halvings()};
  s.linear_method = m.linear().method() == v1::FluidLinear::DIRECT   ? LinearMethod::direct
                    : m.linear().method() == v1::FluidLinear::KRYLOV ? LinearMethod::krylov
                                                                     : LinearMethod::automatic;
  s.linear = {m.linear().tolerance(), m.linear().max_iterations(), m.linear().restart()};
  load_boundaries(m, s, report);
  s.slip_feature_angle = m.slip_feature_angle();
  s.interface_load = m.interface_load() == v1::TRACTION              ? InterfaceLoad::traction
                     : m.interface_load() == v1::CONSISTENT_TRACTION ? InterfaceLoad::consistent_traction
                                                                     : InterfaceLoad::pressure;
  load_forces(m, s, report);
  s.output = {m.output().directory(), m.output().field_interval(), m.output().series_interval()};
  for (const v1::Probe& p : m.probe()) s.probes.push_back({p.name(), {p.x(), p.y(), p.z()}});
  if (m.has_averages()) s.average_from = m.averages().start();
  s.alone_only = alone_only(m);
  return s;
}

} // namespace drogue::fluid
