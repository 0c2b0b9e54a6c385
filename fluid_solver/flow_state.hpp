// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/result.hpp"
#include "common/io/state_file.hpp"
#include "fluid_solver/fluid_mesh.hpp"

namespace drogue::fluid {

/// The committed flow: all that the next step starts from. Node arrays in the solver's order.
struct FlowState {
  double time = 0;
  std::uint64_t step = 0;
  std::vector<double> u;             ///< {n, 3}
  std::vector<double> p;             ///< {n} kinematic pressure
  std::vector<double> x;             ///< {n, 3} positions
  std::vector<double> wall_velocity; ///< {n, 3} velocity of the walls; zero elsewhere
  std::vector<double> u_before;      ///< {n, 3} velocity a step before; empty: not known
  double step_before = 0;            ///< length of that step
};

/// The flow of a state file on its mesh. Errors (ErrorKind::config): another kind of state, another mesh,
/// arrays of other sizes, no velocity or no pressure.
[[nodiscard]] Result<FlowState> flow_state_of(const io::State& file, const FluidMesh& mesh, double density);

/// A flow on another mesh, at rest: velocity and pressure interpolated to its nodes, time and count of steps
/// kept. A node of the boundary takes its values from the side of its own cells, so that both sides of a
/// surface without thickness keep theirs; one outside the old mesh by less than its cells reach (curved
/// boundaries in other facets) those of the nearest cell in their direction. Errors (ErrorKind::config):
/// other dimension; a node that lies outside by more.
[[nodiscard]] Result<FlowState> interpolated(const FlowState& state, const FluidMesh& from,
                                             const FluidMesh& to);

} // namespace drogue::fluid
