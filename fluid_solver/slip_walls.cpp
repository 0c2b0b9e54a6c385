// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/slip_walls.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace drogue::fluid {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

double dot(const double* a, const double* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// A normal adds nothing when less than this part of it is new: one of a plane whose normal component is held
/// already, or the back of a thin surface.
constexpr double new_part = 0.1;

/// Group of each face: linked where normals differ by less than the angle, directly or over others.
std::vector<int> groups(std::span<const std::array<double, 3>> normals, double cosine) {
  std::vector<int> group(normals.size());
  std::iota(group.begin(), group.end(), 0);
  for (std::size_t i = 0; i < normals.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (group[i] != group[j] && dot(normals[i].data(), normals[j].data()) > cosine)
        std::replace(group.begin(), group.end(), std::max(group[i], group[j]), std::min(group[i], group[j]));
  return group;
}

/// The directions of one node as they are found, each with the velocity along it.
struct Frame {
  double n[3][3] = {};
  double velocity[3] = {};
  int count = 0;

  /// Adds u . normal = flux, unless the directions so far say (nearly) all of it.
  void add(const double* normal, double flux) {
    const double length = std::sqrt(dot(normal, normal));
    if (!(length > 0) || count == 3) return;
    double rest[3];
    for (int d = 0; d < 3; ++d) rest[d] = normal[d] / length;
    double velocity_left = flux / length;
    for (int k = 0; k < count; ++k) {
      const double along = dot(rest, n[k]);
      velocity_left -= along * velocity[k];
      for (int d = 0; d < 3; ++d) rest[d] -= along * n[k][d];
    }
    const double size = std::sqrt(dot(rest, rest));
    if (size < new_part) return;
    for (int d = 0; d < 3; ++d) n[count][d] = rest[d] / size;
    velocity[count++] = velocity_left / size;
  }
};

} // namespace

SlipWalls::SlipWalls(std::span<const Face> faces, std::span<const char> fixed, std::span<const double> points,
                     double feature_angle) {
  // 1. faces by node
  std::vector<std::pair<std::int32_t, std::size_t>> corners;
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (const std::int32_t node : faces[f].face.nodes())
      if (const char* held = fixed.data() + 3 * at(node); !held[0] || !held[1] || !held[2])
        corners.emplace_back(node, f);
  std::sort(corners.begin(), corners.end());
  // 2. of each node, those of one normal together
  const double cosine = std::cos(feature_angle * std::numbers::pi / 180);
  std::vector<std::array<double, 3>> normals;
  for (std::size_t first = 0, last = 0; first < corners.size(); first = last) {
    const std::int32_t node = corners[first].first;
    normals.clear();
    for (; last < corners.size() && corners[last].first == node; ++last) {
      auto n = area_vector(faces[corners[last].second].face, points);
      const double length = std::sqrt(dot(n.data(), n.data()));
      for (double& value : n) value /= length;
      normals.push_back(n);
    }
    const std::vector<int> group = groups(normals, cosine);
    nodes_.push_back(node);
    start_.push_back(parts_.size());
    fixed_.insert(fixed_.end(), fixed.begin() + 3 * node, fixed.begin() + 3 * node + 3);
    for (int g = 0; g < static_cast<int>(group.size()); ++g) {
      for (std::size_t k = 0; k < group.size(); ++k)
        if (group[k] == g) parts_.push_back({faces[corners[first + k].second]});
      if (std::find(group.begin(), group.end(), g) != group.end()) parts_.back().last = true;
    }
  }
  start_.push_back(parts_.size());
}

SlipDirections SlipWalls::hold(std::size_t index, std::span<const double> points, const double* wall,
                               double* u) const {
  // 1. what is held already
  Frame frame;
  for (std::size_t d = 0; d < 3; ++d) {
    double axis[3] = {};
    axis[d] = 1;
    if (fixed_[3 * index + d]) frame.add(axis, u[d]);
  }
  const int already = frame.count;
  // 2. the normals; a third of each face belongs to each of its corners, a factor that cancels
  double normal[3] = {};
  double flux = 0;
  for (std::size_t k = start_[index]; k < start_[index + 1]; ++k) {
    const auto area = area_vector(parts_[k].at.face, points);
    for (std::size_t d = 0; d < 3; ++d) normal[d] += area[d];
    if (parts_[k].at.wall) flux += dot(area.data(), wall);
    if (!parts_[k].last) continue;
    frame.add(normal, flux);
    std::fill_n(normal, 3, 0.0);
    flux = 0;
  }
  // 3. the velocity along them
  SlipDirections directions{nodes_[index], frame.count - already, {}};
  for (int k = already; k < frame.count; ++k) {
    const double change = frame.velocity[k] - dot(frame.n[k], u);
    for (int d = 0; d < 3; ++d) {
      directions.n[k - already][d] = frame.n[k][d];
      u[d] += change * frame.n[k][d];
    }
  }
  return directions;
}

std::vector<SlipDirections> SlipWalls::apply(std::span<const double> points,
                                             std::span<const double> wall_velocity,
                                             std::span<double> unknowns, std::size_t stride,
                                             std::size_t offset) const {
  std::vector<SlipDirections> all;
  all.reserve(nodes_.size());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const std::size_t node = at(nodes_[i]);
    all.push_back(hold(i, points, wall_velocity.data() + 3 * node, unknowns.data() + stride * node + offset));
  }
  return all;
}

} // namespace drogue::fluid
