// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/line_forces.hpp"

#include <algorithm>

#include <Eigen/Core>

namespace drogue::structure {
namespace {

std::size_t cell_count(const AnyBatch& any) {
  return std::visit([](const auto& batch) { return batch.count(); }, any);
}

/// The lines of `group` with one end among `nodes`, sorted.
std::vector<LineForce::End> ends_at(const Model& model, const std::string& group,
                                    const std::vector<std::int32_t>& nodes) {
  const auto at = [&](std::int32_t node) { return std::binary_search(nodes.begin(), nodes.end(), node); };
  std::vector<LineForce::End> ends;
  std::size_t first = 0; // cell of the batch
  for (const AnyBatch& any : model.batches) {
    const auto* lines = std::get_if<Batch<Line>>(&any);
    if (lines != nullptr && model.mesh.blocks[lines->block].group == group)
      for (std::size_t e = 0; e < lines->count(); ++e) {
        const std::int32_t* line = lines->element(e);
        if (at(line[0]) != at(line[1]))
          ends.push_back({first + e, at(line[0]) ? line[0] : line[1], at(line[0]) ? line[1] : line[0]});
      }
    first += cell_count(any);
  }
  return ends;
}

} // namespace

std::array<double, 3> LineForce::operator()(const Model& model, const StressFields& stress,
                                            std::span<const double> u) const {
  const auto position = [&](std::int32_t node) {
    const auto i = 3 * static_cast<std::size_t>(node);
    return Eigen::Vector3d(Eigen::Map<const Eigen::Vector3d>(&model.mesh.points[i]) +
                           Eigen::Map<const Eigen::Vector3d>(&u[i]));
  };
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const End& end : ends)
    sum += stress.cell_tension[end.cell] * (position(end.beyond) - position(end.node)).normalized();
  return {sum(0), sum(1), sum(2)};
}

std::vector<LineForce> line_forces(const Settings& settings, const Model& model, config::Report& report) {
  std::vector<std::string> line_groups;
  for (const auto* lines : {&settings.cables, &settings.trusses})
    for (const LineSettings& line : *lines) line_groups.push_back(line.group);
  const std::vector<std::string> groups = model.mesh.group_names();
  std::vector<LineForce> forces;
  for (std::size_t i = 0; i < settings.line_forces.size(); ++i) {
    const LineForceSettings& s = settings.line_forces[i];
    const auto where = [&](const char* field) {
      return settings.source.where(fmt::format("line_force[{}].{}", i, field));
    };
    const auto known = [&](const char* field, const std::string& name,
                           const std::vector<std::string>& names) {
      if (std::find(names.begin(), names.end(), name) != names.end()) return true;
      config::report_unknown_name(report, where(field), "group", name, settings.mesh.string(), names);
      return false;
    };
    if (std::any_of(forces.begin(), forces.end(), [&](const LineForce& f) { return f.name == s.name; }))
      report.error(where("name"), fmt::format("the name \"{}\" is used twice", s.name));
    if (!known("group", s.group, line_groups) || !known("at", s.at, groups)) continue;
    LineForce& force =
        forces.emplace_back(LineForce{s.name, ends_at(model, s.group, model.mesh.nodes_of(s.at))});
    if (force.ends.empty())
      report.error(where("at"),
                   fmt::format("no line of \"{}\" has one end in the group \"{}\"", s.group, s.at));
  }
  return forces;
}

} // namespace drogue::structure
