// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/project/project_state.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include <Eigen/Core>
#include <fmt/core.h>

#include "common/io/state_file.hpp"
#include "coupler/project/surface_file.hpp"
#include "coupler/projection/interface.hpp"

namespace drogue::coupler {
namespace {

using Eigen::Vector3d;

constexpr std::array field_names{"displacement", "velocity", "acceleration"};

Vector3d row(const std::vector<double>& values, std::int32_t node) {
  const std::size_t i = 3 * static_cast<std::size_t>(node);
  return {values[i], values[i + 1], values[i + 2]};
}

/// A point of a two-node line: (1 - t) first + t second.
struct PointOnLine {
  std::int32_t first = -1, second = -1;
  double t = 0;
  double distance = std::numeric_limits<double>::infinity();
};

bool is_line(const mesh::ElementBlock& block) {
  return block.kind == mesh::ElementKind::line2;
}

PointOnLine closest(const mesh::Mesh& m, const std::string& group, const Vector3d& x) {
  PointOnLine best;
  for (const mesh::ElementBlock* block : m.blocks_of(group))
    for (std::int32_t e = 0; is_line(*block) && e < block->count(); ++e) {
      const auto nodes = block->element(e);
      const Vector3d a = row(m.points, nodes[0]), along = row(m.points, nodes[1]) - a;
      const double t = std::clamp(along.dot(x - a) / along.squaredNorm(), 0.0, 1.0);
      const double distance = (a + t * along - x).norm();
      if (distance < best.distance) best = {nodes[0], nodes[1], t, distance};
    }
  return best;
}

/// Where each node of `to` beside its surface lies on the lines of `from`.
struct Lines {
  std::vector<std::int32_t> nodes;
  std::vector<PointOnLine> points;
  double largest_gap = 0; ///< [length]
};

Result<Lines> match_lines(const SurfaceFile& from, const SurfaceFile& to, double largest_gap) {
  std::vector<char> done(static_cast<std::size_t>(to.mesh.node_count()), 0);
  for (const std::int32_t node : to.nodes) done[static_cast<std::size_t>(node)] = 1;
  Lines lines;
  for (const mesh::ElementBlock& block : to.mesh.blocks) {
    if (!is_line(block)) continue;
    for (const std::int32_t node : block.nodes) {
      if (done[static_cast<std::size_t>(node)]) continue;
      done[static_cast<std::size_t>(node)] = 1;
      const Vector3d x = row(to.mesh.points, node);
      const PointOnLine found = closest(from.mesh, block.group, x);
      if (found.first < 0)
        return config_error("the mesh of {} has no lines \"{}\", as that of {} has", from.surface.name,
                            block.group, to.surface.name);
      if (found.distance > largest_gap)
        return config_error(
            "a node of the lines \"{}\" at ({:g}, {:g}, {:g}) is {:g} from the lines of that name in the "
            "mesh of {}: at most {:g} is allowed (--largest-gap)",
            block.group, x[0], x[1], x[2], found.distance, from.surface.name, largest_gap);
      lines.nodes.push_back(node);
      lines.points.push_back(found);
      lines.largest_gap = std::max(lines.largest_gap, found.distance);
    }
  }
  if (const auto left = std::find(done.begin(), done.end(), 0); left != done.end())
    return config_error("node {} of the mesh of {} is neither on its surface nor on a line",
                        left - done.begin(), to.surface.name);
  return lines;
}

Result<io::State> read(const ProjectCommand& command, const SurfaceFile& from) {
  auto state = io::read_state(command.state);
  if (!state) return state.error();
  const std::string file = command.state.string();
  if (state->kind != "structure")
    return config_error("{}: holds a state of kind \"{}\"; one of kind \"structure\" is needed", file,
                        state->kind);
  if (state->mesh_hash != mesh::hash(from.mesh))
    return config_error("{}: the state belongs to another mesh than {}", file, command.from.string());
  for (const char* name : field_names) {
    const io::StateArray* array = state->find(name);
    if (!array || array->values.size() != from.mesh.points.size())
      return config_error("{}: the state has no array \"{}\" of shape {{{}, 3}}", file, name,
                          from.mesh.node_count());
  }
  return state;
}

std::vector<double> on_surface(const std::vector<double>& values, const std::vector<std::int32_t>& nodes) {
  std::vector<double> chosen(3 * nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    std::copy_n(values.begin() + 3 * std::ptrdiff_t{nodes[i]}, 3,
                chosen.begin() + 3 * static_cast<std::ptrdiff_t>(i));
  return chosen;
}

/// One field on all nodes of `to`, from its values on those of `from`.
/// @param missed filled with the part of it that the surface of `to` cannot show
Result<std::vector<double>> carry(const SurfaceFile& from, const SurfaceFile& to,
                                  projection::Interface& surfaces, const Lines& lines,
                                  const std::vector<double>& values, double& missed) {
  const std::vector<double> given = on_surface(values, from.nodes);
  std::vector<double> received(3 * to.nodes.size());
  DROGUE_TRY(surfaces.field.apply(given, received));
  missed = projection::projection_defect(surfaces, given, received);
  std::vector<double> result(to.mesh.points.size());
  for (std::size_t i = 0; i < to.nodes.size(); ++i)
    std::copy_n(received.begin() + 3 * static_cast<std::ptrdiff_t>(i), 3,
                result.begin() + 3 * std::ptrdiff_t{to.nodes[i]});
  for (std::size_t i = 0; i < lines.nodes.size(); ++i) {
    const PointOnLine& p = lines.points[i];
    const Vector3d value = (1 - p.t) * row(values, p.first) + p.t * row(values, p.second);
    std::copy_n(value.data(), 3, result.begin() + 3 * std::ptrdiff_t{lines.nodes[i]});
  }
  return result;
}

} // namespace

Result<void> project_state(const ProjectCommand& command) {
  const auto from = read_surface(command.from, command.from_group);
  if (!from) return from.error();
  const auto to = read_surface(command.to, command.to_group);
  if (!to) return to.error();
  const auto state = read(command, *from);
  if (!state) return state.error();
  projection::Settings settings = command.settings;
  settings.recover_traction = false; // nothing of that direction is asked for
  auto surfaces = projection::make_interface(from->surface, to->surface, settings);
  if (!surfaces) return surfaces.error();
  const auto lines = match_lines(*from, *to, settings.largest_gap * projection::extent(from->mesh.points));
  if (!lines) return lines.error();

  fmt::print("from {} to {}: {} nodes by {}, {} nodes on lines, at most {:.3g} from those they follow\n",
             from->surface.name, to->surface.name, to->nodes.size(),
             surfaces->report.matching ? "copying" : "least squares", lines->nodes.size(),
             lines->largest_gap);
  io::State result{"structure", mesh::hash(to->mesh), state->time, state->step, {}};
  for (const char* name : field_names) {
    double missed = 0;
    auto values = carry(*from, *to, *surfaces, *lines, state->find(name)->values, missed);
    if (!values) return values.error();
    fmt::print("  {}: {:.3g} of it, in the mean over the surface, is missed\n", name, missed);
    result.add(name, {static_cast<std::uint64_t>(to->mesh.node_count()), 3}, std::move(*values));
  }
  DROGUE_TRY(io::write_state(command.output, result));
  fmt::print("written to {}\n", command.output.string());
  return {};
}

} // namespace drogue::coupler
