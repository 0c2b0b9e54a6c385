// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/boundary_motion.hpp"

#include <algorithm>
#include <limits>

namespace drogue::mesh_mover {
namespace {

constexpr std::uint8_t all_given = 7;
constexpr std::uint8_t out_of_plane = 4;
constexpr int no_owner = -1;

/// Smaller is stronger.
int rank(const Boundary& boundary) {
  if (boundary.is_interface) return 0;
  switch (boundary.condition) {
  case Condition::displacement:
    return 1;
  case Condition::fixed:
  case Condition::translated:
    return 2;
  case Condition::sliding:
    return 3;
  }
  return 3;
}

} // namespace

Result<BoundaryMotion> BoundaryMotion::create(const mesh::Mesh& mesh, int dimension,
                                              std::vector<Boundary> boundaries) {
  BoundaryMotion motion(std::move(boundaries));
  motion.assign(mesh, dimension);
  for (int c = 0; c < 3; ++c)
    if (std::none_of(motion.given_.begin(), motion.given_.end(), [c](std::uint8_t g) { return g >> c & 1; }))
      return config_error(
          "no boundary holds the mesh in the direction {}; give a boundary a displacement, or make it "
          "fixed, translated or sliding with that normal",
          "xyz"[c]);
  return motion;
}

std::vector<std::int32_t> BoundaryMotion::displaced_nodes() const {
  std::vector<std::int32_t> nodes;
  for (std::size_t k = 0; k < boundaries_.size(); ++k)
    if (boundaries_[k].condition == Condition::displacement)
      nodes.insert(nodes.end(), owned_[k].begin(), owned_[k].end());
  std::sort(nodes.begin(), nodes.end());
  return nodes;
}

void BoundaryMotion::assign(const mesh::Mesh& mesh, int dimension) {
  const auto n = static_cast<std::size_t>(mesh.node_count());
  given_.assign(n, dimension == 2 ? out_of_plane : 0);
  std::vector<int> owner(n, no_owner);
  for (std::size_t k = 0; k < boundaries_.size(); ++k) {
    const Boundary& boundary = boundaries_[k];
    for (const std::int32_t node : mesh.nodes_of(boundary.name)) {
      const auto i = static_cast<std::size_t>(node);
      if (boundary.is_interface) interface_nodes_.push_back(node);
      if (boundary.condition == Condition::sliding) {
        given_[i] |= static_cast<std::uint8_t>(1 << boundary.normal);
        continue;
      }
      if (owner[i] == no_owner || rank(boundary) < rank(boundaries_[static_cast<std::size_t>(owner[i])]))
        owner[i] = static_cast<int>(k);
    }
  }
  owned_.resize(boundaries_.size());
  for (std::size_t i = 0; i < n; ++i) {
    if (owner[i] == no_owner) continue;
    given_[i] = all_given;
    owned_[static_cast<std::size_t>(owner[i])].push_back(static_cast<std::int32_t>(i));
  }
  std::sort(interface_nodes_.begin(), interface_nodes_.end());
  interface_nodes_.erase(std::unique(interface_nodes_.begin(), interface_nodes_.end()),
                         interface_nodes_.end());
}

void BoundaryMotion::evaluate(const BoundaryInput& input, std::span<const double> initial_points,
                              std::span<double> u) const {
  // Sliding components stay where they were; owned nodes are overwritten below.
  for (std::size_t i = 0; i < given_.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      if (given_[i] >> c & 1) u[3 * i + c] = 0;
  for (std::size_t k = 0; k < boundaries_.size(); ++k) {
    const Boundary& boundary = boundaries_[k];
    if (boundary.is_interface && !input.interface_displacement.empty()) continue;
    for (const std::int32_t node : owned_[k]) {
      const double* X = initial_points.data() + 3 * static_cast<std::size_t>(node);
      double* value = u.data() + 3 * static_cast<std::size_t>(node);
      for (std::size_t c = 0; c < 3; ++c) {
        if (boundary.condition == Condition::displacement)
          value[c] = boundary.displacement[c](X[0], X[1], X[2], input.time);
        if (boundary.condition == Condition::translated) value[c] = input.translation[c];
      }
    }
  }
  if (input.interface_displacement.empty()) return;
  for (std::size_t k = 0; k < interface_nodes_.size(); ++k)
    std::copy_n(&input.interface_displacement[3 * k], 3,
                &u[3 * static_cast<std::size_t>(interface_nodes_[k])]);
}

} // namespace drogue::mesh_mover
