// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/boundary_conditions.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace drogue::fluid {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

const BoundarySettings* find(const Settings& settings, const std::string& name) {
  const auto found = std::find_if(settings.boundaries.begin(), settings.boundaries.end(),
                                  [&](const BoundarySettings& b) { return b.name == name; });
  return found == settings.boundaries.end() ? nullptr : &*found;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// A plane flow has no third components.
void check_plane(const Settings& settings, config::Report& report) {
  const auto check = [&](const std::string& path, const config::VectorExpression& value) {
    if (!value[2].is_zero())
      report.error(settings.source.where(path + ".z"),
                   "the mesh is two-dimensional: a component along z has no meaning; leave z out");
  };
  check("initial_velocity", settings.initial_velocity);
  check("body_force", settings.body_force);
  for (std::size_t i = 0; i < settings.boundaries.size(); ++i) {
    const Condition condition = settings.boundaries[i].condition;
    if (condition == Condition::velocity || condition == Condition::traction)
      check(fmt::format("boundary[{}].{}", i, condition == Condition::velocity ? "velocity" : "traction"),
            settings.boundaries[i].value);
  }
  for (std::size_t i = 0; i < settings.phases.size(); ++i)
    if (const auto& moved = settings.phases[i].mesh_displacement)
      check(fmt::format("phase[{}].mesh_displacement", i), *moved);
}

} // namespace

void check_against_mesh(const Settings& settings, const FluidMesh& mesh, config::Report& report) {
  const std::string file = settings.mesh.filename().string();
  const auto check = [&](const std::string& path, const std::string& name) {
    if (!contains(mesh.boundaries, name))
      config::report_unknown_name(report, settings.source.where(path), "boundary", name, file,
                                  mesh.boundaries);
  };
  for (std::size_t i = 0; i < settings.boundaries.size(); ++i)
    check(fmt::format("boundary[{}].name", i), settings.boundaries[i].name);
  for (std::size_t i = 0; i < settings.interface.size(); ++i)
    check(fmt::format("interface[{}]", i), settings.interface[i]);
  for (std::size_t i = 0; i < settings.forces.size(); ++i)
    for (std::size_t k = 0; k < settings.forces[i].boundaries.size(); ++k)
      check(fmt::format("force[{}].boundary[{}]", i, k), settings.forces[i].boundaries[k]);
  if (mesh.dimension == 2) check_plane(settings, report);
  for (const std::string& name : mesh.boundaries)
    if (find(settings, name) == nullptr)
      report.error(
          settings.source.where("boundary"),
          fmt::format("boundary \"{}\" of {} has no condition; add a boundary {{ name: \"{}\" ... }}", name,
                      file, name));
}

std::vector<std::int32_t> boundary_indices(const FluidMesh& mesh, std::span<const std::string> names) {
  std::vector<std::int32_t> indices;
  for (const std::string& name : names)
    indices.push_back(static_cast<std::int32_t>(
        std::find(mesh.boundaries.begin(), mesh.boundaries.end(), name) - mesh.boundaries.begin()));
  return indices;
}

VelocityConstraints::VelocityConstraints(const Settings& settings, const FluidMesh& mesh)
    : boundaries_(settings.boundaries), fixed_(3 * at(mesh.node_count()), 0) {
  if (mesh.dimension == 2) // no velocity out of the plane
    for (std::size_t i = 2; i < fixed_.size(); i += 3) fixed_[i] = 1;
  std::vector<std::int32_t> condition_of(mesh.boundaries.size(), 0);
  for (std::size_t k = 0; k < mesh.boundaries.size(); ++k)
    condition_of[k] =
        static_cast<std::int32_t>(find(settings, mesh.boundaries[k]) - settings.boundaries.data());
  bool open = false;
  for (const Condition pass : {Condition::no_slip, Condition::velocity}) {
    for (const BoundaryFace& face : mesh.faces) {
      const std::int32_t index = condition_of[at(face.boundary)];
      const BoundarySettings& b = boundaries_[at(index)];
      if (b.condition != pass) continue;
      for (const std::int32_t node : face.nodes())
        for (int d = 0; d < 3; ++d)
          if (pass == Condition::velocity || b.components[static_cast<std::size_t>(d)]) add(node, d, index);
      const auto area = area_vector(face, mesh.points);
      const double size = std::hypot(area[0], area[1], area[2]);
      for (std::size_t d = 0; d < 3; ++d) // a wall that does not hold its normal component
        open = open || (pass == Condition::no_slip && !b.components[d] && std::fabs(area[d]) > 1e-6 * size);
    }
  }
  std::vector<SlipWalls::Face> slip;
  for (const BoundaryFace& face : mesh.faces)
    if (const auto& b = boundaries_[at(condition_of[at(face.boundary)])]; b.condition == Condition::free_slip)
      slip.push_back({face, b.slip_wall});
  slip_ = SlipWalls(slip, fixed_, mesh.points, settings.slip_feature_angle);
  for (const BoundaryFace& face : mesh.faces)
    if (boundaries_[at(condition_of[at(face.boundary)])].is_open())
      open_nodes_.insert(open_nodes_.end(), face.nodes().begin(), face.nodes().end());
  std::sort(open_nodes_.begin(), open_nodes_.end());
  open_nodes_.erase(std::unique(open_nodes_.begin(), open_nodes_.end()), open_nodes_.end());
  if (!open && open_nodes_.empty()) pinned_ = mesh.from_file[0];
}

void VelocityConstraints::add(std::int32_t node, int component, std::int32_t boundary) {
  char& fixed = fixed_[3 * at(node) + static_cast<std::size_t>(component)];
  if (fixed) return;
  fixed = 1;
  entries_.push_back({node, component, boundary});
}

std::vector<SlipDirections> VelocityConstraints::apply(double t, std::span<const double> points,
                                                       std::span<const double> wall_velocity,
                                                       std::span<double> unknowns, std::size_t stride,
                                                       std::size_t offset) const {
  for (const Entry& e : entries_) {
    const BoundarySettings& b = boundaries_[at(e.boundary)];
    const double* x = points.data() + 3 * at(e.node);
    const auto d = static_cast<std::size_t>(e.component);
    unknowns[stride * at(e.node) + offset + d] = b.condition == Condition::velocity
                                                     ? b.value[d](x[0], x[1], x[2], t)
                                                     : wall_velocity[3 * at(e.node) + d];
  }
  return slip_.apply(points, wall_velocity, unknowns, stride, offset);
}

std::string VelocityConstraints::not_finite(double t, std::span<const double> points) const {
  for (const Entry& e : entries_) {
    const BoundarySettings& b = boundaries_[at(e.boundary)];
    if (b.condition != Condition::velocity) continue;
    const double* x = points.data() + 3 * at(e.node);
    const auto d = static_cast<std::size_t>(e.component);
    if (const double value = b.value[d](x[0], x[1], x[2], t); !std::isfinite(value))
      return fmt::format(
          "the velocity of boundary \"{}\", {}: \"{}\", is {} at ({:.6g}, {:.6g}, {:.6g}), t = {:.6g}",
          b.name, "xyz"[d], b.value[d].text(), value, x[0], x[1], x[2], t);
  }
  return {};
}

} // namespace drogue::fluid
