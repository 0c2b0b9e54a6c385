// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/settings.hpp"

#include <algorithm>
#include <set>

#include "common/config/config.hpp"
#include "common/mesh/msh.hpp"
#include "drogue/v1/mesh_mover.pb.h"

namespace drogue::mesh_mover {
namespace {

/// Checks what the schema's own rules cannot.
class Checker {
 public:
  Checker(const v1::MeshMoverConfig& config, const config::Source& source, config::Report& report)
      : config_(config), source_(source), report_(report) {}

  void boundaries();
  void interface();
  void method();
  void against(const mesh::Mesh& mesh);

 private:
  void in_plane();
  std::string at(const std::string& path) const { return source_.where(path); }
  const v1::MovingBoundary* find(const std::string& name) const;

  const v1::MeshMoverConfig& config_;
  const config::Source& source_;
  config::Report& report_;
};

const v1::MovingBoundary* Checker::find(const std::string& name) const {
  for (const auto& boundary : config_.boundary())
    if (boundary.name() == name) return &boundary;
  return nullptr;
}

void Checker::boundaries() {
  std::set<std::string> seen;
  for (int i = 0; i < config_.boundary_size(); ++i) {
    const auto& boundary = config_.boundary(i);
    const std::string path = fmt::format("boundary[{}]", i);
    if (boundary.has_name() && !seen.insert(boundary.name()).second)
      report_.error(at(path + ".name"), fmt::format("boundary \"{}\" is given twice", boundary.name()));
    if (boundary.condition_case() == v1::MovingBoundary::CONDITION_NOT_SET)
      report_.error(at(path),
                    fmt::format("boundary \"{}\" needs a condition: displacement, fixed, translated or "
                                "sliding",
                                boundary.name()));
    if (boundary.has_sliding() && boundary.sliding().has_normal()) {
      const std::string& normal = boundary.sliding().normal();
      if (normal != "x" && normal != "y" && normal != "z")
        report_.error(at(path + ".sliding.normal"),
                      fmt::format("normal is \"{}\"; it must be \"x\", \"y\" or \"z\"", normal));
    }
  }
}

void Checker::interface() {
  std::vector<std::string> names;
  for (const auto& boundary : config_.boundary()) names.push_back(boundary.name());
  std::set<std::string> seen;
  for (int i = 0; i < config_.interface_size(); ++i) {
    const std::string& name = config_.interface(i);
    const std::string where = at(fmt::format("interface[{}]", i));
    if (!seen.insert(name).second) report_.error(where, fmt::format("interface \"{}\" is given twice", name));
    const auto* boundary = find(name);
    if (!boundary)
      config::report_unknown_name(report_, where, "boundary", name, "this config", names);
    else if (!boundary->has_displacement())
      report_.error(
          where, fmt::format("interface \"{}\" must be a boundary with a displacement (displacement {{}}), "
                             "which the coupler's replaces",
                             name));
  }
}

void Checker::method() {
  const bool algebraic = config_.method() == v1::MeshMoverConfig::ALGEBRAIC;
  const auto refuse = [&](bool is_given, const char* field, const char* method) {
    if (is_given)
      report_.error(at(field), fmt::format("{} has no meaning with method: {}; leave it out", field, method));
  };
  refuse(algebraic && config_.has_stiffening_exponent(), "stiffening_exponent", "ALGEBRAIC");
  refuse(algebraic && config_.has_poisson_ratio(), "poisson_ratio", "ALGEBRAIC");
  refuse(algebraic && config_.has_stiff_layers(), "stiff_layers", "ALGEBRAIC");
  refuse(algebraic && config_.has_linear_solver(), "linear_solver", "ALGEBRAIC");
  refuse(!algebraic && config_.has_weight_exponent(), "weight_exponent", "ELASTIC");
}

void Checker::in_plane() {
  for (int i = 0; i < config_.boundary_size(); ++i) {
    const auto& boundary = config_.boundary(i);
    const std::string path = fmt::format("boundary[{}]", i);
    if (boundary.has_sliding() && boundary.sliding().normal() == "z")
      report_.error(at(path + ".sliding.normal"),
                    fmt::format("normal is \"z\", but {} is two-dimensional: it must be \"x\" or \"y\"",
                                config_.mesh()));
    if (boundary.has_displacement() && boundary.displacement().has_z())
      report_.error(at(path + ".displacement.z"),
                    fmt::format("{} is two-dimensional: a displacement has no z", config_.mesh()));
  }
}

void Checker::against(const mesh::Mesh& mesh) {
  std::vector<std::string> groups;
  std::set<std::string> refused;
  const Cells cells = cells_of(mesh);
  const auto side = cells.dimension == 2 ? mesh::ElementKind::line2 : mesh::ElementKind::tri3;
  for (const auto& block : mesh.blocks) {
    if (block.kind == side) {
      if (std::find(groups.begin(), groups.end(), block.group) == groups.end()) groups.push_back(block.group);
    } else if (mesh::dimension(block.kind) >= 2 && block.kind != mesh::ElementKind::tet4 &&
               block.kind != mesh::ElementKind::tri3) {
      refused.insert(fmt::format("{}s in group \"{}\"", mesh::name(block.kind), block.group));
    }
  }
  for (const auto& what : refused)
    report_.error(at("mesh"),
                  fmt::format("{} has {}; mesh_mover takes 4-node tetrahedra and 3-node triangles",
                              config_.mesh(), what));
  if (cells.count() == 0) {
    report_.error(at("mesh"), fmt::format("{} has neither tetrahedra nor triangles in one plane z = const",
                                          config_.mesh()));
    return;
  }
  if (cells.dimension == 2) in_plane();
  for (int i = 0; i < config_.boundary_size(); ++i) {
    const auto& name = config_.boundary(i).name();
    if (std::find(groups.begin(), groups.end(), name) == groups.end())
      config::report_unknown_name(report_, at(fmt::format("boundary[{}].name", i)), "boundary", name,
                                  config_.mesh(), groups);
  }
  for (const auto& group : groups)
    if (!find(group))
      report_.error(at("mesh"),
                    fmt::format("boundary \"{}\" of {} is not mentioned; give it a condition, e.g. "
                                "boundary {{ name: \"{}\" fixed {{}} }}",
                                group, config_.mesh(), group));
}

config::Expression expression(const std::string& text) {
  auto parsed = config::Expression::parse(text); // the schema's rule has checked it
  return parsed ? std::move(*parsed) : config::Expression();
}

Boundary boundary_settings(const v1::MovingBoundary& from, const v1::MeshMoverConfig& config) {
  Boundary boundary;
  boundary.name = from.name();
  switch (from.condition_case()) {
  case v1::MovingBoundary::kDisplacement: {
    const auto& d = from.displacement();
    boundary.condition = Condition::displacement;
    boundary.displacement = {expression(d.x()), expression(d.y()), expression(d.z())};
    break;
  }
  case v1::MovingBoundary::kTranslated:
    boundary.condition = Condition::translated;
    break;
  case v1::MovingBoundary::kSliding:
    boundary.condition = Condition::sliding;
    boundary.normal = from.sliding().normal().front() - 'x';
    break;
  case v1::MovingBoundary::kFixed:
  case v1::MovingBoundary::CONDITION_NOT_SET:
    boundary.condition = Condition::fixed;
    break;
  }
  const auto& interface = config.interface();
  boundary.is_interface = std::find(interface.begin(), interface.end(), from.name()) != interface.end();
  return boundary;
}

Limits limits_from(const v1::MeshLimits& from) {
  Limits limits;
  limits.mean_ratio = from.mean_ratio();
  limits.angle = from.angle();
  if (from.has_f_a()) limits.f_A = from.f_a();
  if (from.has_f_ar()) limits.f_AR = from.f_ar();
  return limits;
}

LinearSolverKind linear_solver_from(v1::MeshMoverConfig::LinearSolver kind) {
  switch (kind) {
  case v1::MeshMoverConfig::DIRECT:
    return LinearSolverKind::direct;
  case v1::MeshMoverConfig::ITERATIVE:
    return LinearSolverKind::iterative;
  case v1::MeshMoverConfig::AUTOMATIC:
    break;
  }
  return LinearSolverKind::automatic;
}

Settings settings_from(const v1::MeshMoverConfig& config) {
  Settings s;
  s.method = config.method() == v1::MeshMoverConfig::ALGEBRAIC ? Method::algebraic : Method::elastic;
  s.weight_exponent = config.weight_exponent();
  s.stiffening_exponent = config.stiffening_exponent();
  s.poisson_ratio = config.poisson_ratio();
  s.increment = config.increment() == v1::MeshMoverConfig::FROM_INITIAL ? Increment::from_initial
                                                                        : Increment::from_last_step;
  for (const auto& boundary : config.boundary()) s.boundaries.push_back(boundary_settings(boundary, config));
  s.tolerance = config.tolerance();
  s.max_iterations = config.max_iterations();
  if (config.has_stiff_layers())
    s.stiff_layers = {config.stiff_layers().layers(), config.stiff_layers().factor()};
  s.linear_solver = linear_solver_from(config.linear_solver());
  s.warn = limits_from(config.warn());
  s.stop = limits_from(config.stop());
  if (config.has_remesh()) s.remesh = limits_from(config.remesh());
  s.stop.min_volume_ratio = config.smallest_volume_ratio();
  s.max_sub_increments = config.max_sub_increments();
  s.step = config.step();
  s.steps = config.steps();
  s.output = {config.output().directory(), config.output().field_interval(),
              config.output().series_interval()};
  return s;
}

} // namespace

Result<Case> load_case(const std::filesystem::path& file, Role role) {
  v1::MeshMoverConfig config;
  config::Report report;
  const config::Source source = config::load(file, config, report);
  if (!source.parsed()) return report.as_error();
  Checker check(config, source, report);
  check.boundaries();
  check.interface();
  check.method();
  if (role == Role::participant && config.interface_size() == 0)
    report.error(source.where("interface"),
                 "a participant needs interface: the boundaries that follow the structure");
  const std::filesystem::path mesh_file = source.resolve(config.mesh());
  if (!config.has_mesh() || !std::filesystem::is_regular_file(mesh_file)) {
    if (report.ok()) report.error(source.where("mesh"), fmt::format("{} is not a file", mesh_file.string()));
    return report.as_error();
  }
  auto mesh = mesh::read_msh(mesh_file);
  if (mesh)
    check.against(*mesh);
  else
    report.error(source.where("mesh"), mesh.error().message);
  if (!report.ok()) return report.as_error();
  return Case{settings_from(config), std::move(*mesh)};
}

} // namespace drogue::mesh_mover
