// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/flow_state.hpp"

#include <algorithm>
#include <numeric>

#include "common/meshing/simplex_locator.hpp"

namespace drogue::fluid {
namespace {

using meshing::Point;

/// A smallest weight above this counts as inside.
constexpr double inside = -1e-9;

Point point(std::span<const double> x, std::size_t node) {
  return {x[3 * node], x[3 * node + 1], x[3 * node + 2]};
}

/// Mean of the centres of each node's cells.
std::vector<Point> centres_around(const FluidMesh& mesh) {
  const auto n = static_cast<std::size_t>(mesh.node_count());
  std::vector<Point> sum(n, Point::Zero());
  std::vector<int> count(n, 0);
  for (std::int32_t e = 0; e < mesh.cell_count(); ++e) {
    Point centre = Point::Zero();
    for (const std::int32_t node : mesh.cell(e)) centre += point(mesh.points, static_cast<std::size_t>(node));
    centre /= static_cast<double>(mesh.cell_nodes());
    for (const std::int32_t node : mesh.cell(e)) {
      sum[static_cast<std::size_t>(node)] += centre;
      ++count[static_cast<std::size_t>(node)];
    }
  }
  for (std::size_t i = 0; i < n; ++i) sum[i] /= std::max(1, count[i]);
  return sum;
}

/// Fills in velocity and pressure. Returns the first node that has no cell, else -1.
template <std::size_t D>
std::int32_t interpolate(const FlowState& state, const FluidMesh& from, const FluidMesh& to, FlowState& out) {
  std::vector<Point> points;
  for (std::size_t i = 0; i < state.p.size(); ++i) points.push_back(point(state.x, i));
  std::vector<std::array<std::int32_t, D + 1>> cells(static_cast<std::size_t>(from.cell_count()));
  for (std::size_t e = 0; e < cells.size(); ++e)
    std::copy_n(from.cell(static_cast<std::int32_t>(e)).begin(), D + 1, cells[e].begin());
  const meshing::SimplexLocator<D> locator(points, cells);
  const std::vector<Point> centres = centres_around(to);
  std::vector<std::int32_t> all(to.boundaries.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<char> on_boundary(out.p.size(), 0);
  for (const std::int32_t node : to.nodes_of(all)) on_boundary[static_cast<std::size_t>(node)] = 1;

  meshing::SimplexPlace<D> near;
  for (std::size_t i = 0; i < out.p.size(); ++i) {
    const Point x = point(to.points, i);
    near.cell = std::max(near.cell, 0);
    bool found = false;
    for (const double inwards : {0.0, 0.1, 0.5, 1.0}) { // to the centre of the node's cells
      if (inwards == 0 && on_boundary[i]) continue;     // which side it is on the point itself cannot say
      near = locator.find(x + inwards * (centres[i] - x), near.cell);
      if ((found = near.smallest() > inside)) break;
    }
    if (!found) return static_cast<std::int32_t>(i);
    auto place = locator.place(near.cell, x);
    double sum = 0;
    for (double& w : place.weight) sum += w = std::max(w, 0.0);
    for (std::size_t a = 0; a <= D; ++a) {
      const auto node = static_cast<std::size_t>(cells[static_cast<std::size_t>(near.cell)][a]);
      const double w = place.weight[a] / sum;
      for (std::size_t d = 0; d < 3; ++d) out.u[3 * i + d] += w * state.u[3 * node + d];
      out.p[i] += w * state.p[node];
    }
  }
  return -1;
}

} // namespace

Result<FlowState> flow_state_of(const io::State& file, const FluidMesh& mesh, double density) {
  if (file.kind != "fluid") return config_error("the state is of kind \"{}\", not \"fluid\"", file.kind);
  if (file.mesh_hash != mesh.hash)
    return config_error("the state lives on another mesh (hash {}) than this one (hash {})", file.mesh_hash,
                        mesh.hash);
  FlowState s;
  s.time = file.time;
  s.step = file.step;
  s.x = mesh.points;
  s.wall_velocity.assign(mesh.points.size(), 0.0);
  const auto n = static_cast<std::size_t>(mesh.node_count());
  const auto read = [&](const char* name, int components, std::vector<double>& to) -> Result<bool> {
    const io::StateArray* array = file.find(name);
    if (array == nullptr) return false;
    if (array->values.size() != n * static_cast<std::size_t>(components))
      return config_error("array \"{}\" of the state has {} values; {} nodes need {}", name,
                          array->values.size(), n, n * static_cast<std::size_t>(components));
    to = mesh.reordered_from_file(array->values, components);
    return true;
  };
  for (const auto& found :
       {read("velocity", 3, s.u), read("wall_velocity", 3, s.wall_velocity), read("position", 3, s.x)})
    if (!found) return found.error();
  auto kinematic = read("kinematic_pressure", 1, s.p);
  if (!kinematic) return kinematic.error();
  if (!*kinematic) {
    const auto physical = read("pressure", 1, s.p);
    if (!physical) return physical.error();
    for (double& value : s.p) value /= density;
  }
  const auto before = read("velocity_before", 3, s.u_before);
  if (!before) return before.error();
  if (const io::StateArray* step = file.find("step_before"); step != nullptr && step->values.size() == 1)
    s.step_before = step->values[0];
  if (!(s.step_before > 0)) s.u_before.clear();
  if (s.u.empty() || s.p.empty()) return config_error("the state has no velocity or no pressure");
  return s;
}

Result<FlowState> interpolated(const FlowState& state, const FluidMesh& from, const FluidMesh& to) {
  if (from.dimension != to.dimension)
    return config_error("the state's mesh has {} dimensions, this one {}", from.dimension, to.dimension);
  FlowState out;
  out.time = state.time;
  out.step = state.step;
  out.x = to.points;
  out.u.assign(to.points.size(), 0.0);
  out.p.assign(to.points.size() / 3, 0.0);
  out.wall_velocity.assign(to.points.size(), 0.0);
  const std::int32_t lost =
      to.dimension == 2 ? interpolate<2>(state, from, to, out) : interpolate<3>(state, from, to, out);
  if (lost < 0) return out;
  const Point x = point(to.points, static_cast<std::size_t>(lost));
  return config_error(
      "node {} of this mesh, ({:.6g}, {:.6g}, {:.6g}), lies outside the state's mesh: both must fill "
      "the same domain",
      to.to_file[static_cast<std::size_t>(lost)], x[0], x[1], x[2]);
}

} // namespace drogue::fluid
