// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fluid_solver/fluid_mesh.hpp"
#include "fluid_solver/settings.hpp"
#include "fluid_solver/slip_walls.hpp"

namespace drogue::fluid {

/// Reports every name of the settings that the mesh does not have and boundaries without a condition.
void check_against_mesh(const Settings& settings, const FluidMesh& mesh, config::Report& report);

/// Which velocities are prescribed at which nodes, and by what. Where boundaries meet, a component is taken
/// by no-slip before velocity, what these leave by free slip, in its own directions; tractions take the rest.
class VelocityConstraints {
 public:
  /// @pre check_against_mesh found nothing
  VelocityConstraints(const Settings& settings, const FluidMesh& mesh);

  /// 1 where component d of node i is prescribed by no-slip or velocity, at 3 i + d.
  [[nodiscard]] std::span<const char> fixed() const { return fixed_; }
  /// Says which boundary prescribes a velocity that is not a number at t, and where; empty when none does.
  [[nodiscard]] std::string not_finite(double t, std::span<const double> points) const;
  /// Node whose pressure is held because no boundary is open; -1 when one is.
  [[nodiscard]] std::int32_t pinned_node() const { return pinned_; }
  /// Nodes that free slip holds in directions of its own.
  [[nodiscard]] std::span<const std::int32_t> slip_nodes() const { return slip_.nodes(); }
  /// Nodes that lie on open boundaries.
  [[nodiscard]] std::span<const std::int32_t> open_nodes() const { return open_nodes_; }

  /// Writes the prescribed velocities at time t into unknowns[stride i + offset + d]. points, wall_velocity
  /// {n, 3}: positions and velocities of the walls at t. Returns the directions of the slip nodes at t.
  std::vector<SlipDirections> apply(double t, std::span<const double> points,
                                    std::span<const double> wall_velocity, std::span<double> unknowns,
                                    std::size_t stride, std::size_t offset) const;

 private:
  struct Entry {
    std::int32_t node = 0;
    std::int32_t component = 0;
    std::int32_t boundary = -1; ///< index into the settings' boundaries
  };
  void add(std::int32_t node, int component, std::int32_t boundary);

  std::vector<BoundarySettings> boundaries_;
  std::vector<char> fixed_;
  std::vector<Entry> entries_;
  SlipWalls slip_;
  std::vector<std::int32_t> open_nodes_;
  std::int32_t pinned_ = -1;
};

/// Index into mesh.boundaries of each of the names. @pre the names exist
[[nodiscard]] std::vector<std::int32_t> boundary_indices(const FluidMesh& mesh,
                                                         std::span<const std::string> names);

} // namespace drogue::fluid
