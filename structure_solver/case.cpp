// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/case.hpp"

#include <fmt/core.h>

#include "common/mesh/msh.hpp"
#include "structure_solver/state_io.hpp"

namespace drogue::structure {
namespace {

Result<State> start_state(const Settings& settings, const Model& model) {
  if (!settings.initial_state) return rest_state(model);
  auto state = read_state(*settings.initial_state, model);
  if (!state || !settings.initial_at_rest) return state;
  State rest = rest_state(model);
  rest.u = std::move(state->u);
  return rest;
}

void check_participant(const Settings& s, config::Report& report) {
  const config::Source& source = s.source;
  if (s.interface.empty())
    report.error(source.where("interface"),
                 "a participant needs interface: the membrane group that meets the fluid");
  if (s.time.mode != TimeMode::dynamic)
    report.error(source.where("time.mode"),
                 "a participant needs time.mode: DYNAMIC; static equilibrium is for a stand-alone run");
  if (s.final_state)
    report.error(source.where("final_state"),
                 "final_state is ignored by a participant, whose states the coupler keeps: leave it out");
}

} // namespace

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
  auto model = build_model(c.settings, std::move(*mesh), report);
  if (!model) return report.as_error();
  c.model = std::make_unique<const Model>(std::move(*model));
  if (!c.settings.initial_state || std::filesystem::is_regular_file(*c.settings.initial_state, ignored)) {
    auto start = start_state(c.settings, *c.model);
    if (start)
      c.start = std::move(*start);
    else
      report.error(c.settings.source.where("initial_state"), start.error().message);
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
