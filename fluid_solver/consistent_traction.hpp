// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.hpp"
#include "fluid_solver/flow_solver.hpp"

namespace drogue::fluid {

/// Nodal forces of the fluid on its boundary at the end of the step, from the residual R of the discrete
/// momentum equations [force]. Semi-discrete: f = -rho R. DSD/SST: a force linear in time over the slab
/// weighs as the test functions, R_0 = -dt/6 (2 f_0 + f_1)/rho, R_1 = -dt/6 (f_0 + 2 f_1)/rho, so that
///   f_1 = -rho 2/dt (2 R_1 - R_0).
/// {n, 3}, on every rank; inside the fluid it is the unbalance left by the solver. @pre finish() of this
/// state.
/// @note Collective
[[nodiscard]] std::vector<double> nodal_forces(const Settings& settings, const FluidMesh& mesh,
                                               const FlowSolver& solver);

/// Their mean over the step: f = -rho (R_0 + R_1)/dt. @note Collective
[[nodiscard]] std::vector<double> mean_nodal_forces(const Settings& settings, const FluidMesh& mesh,
                                                    const FlowSolver& solver);

/// The traction t_b N_b whose nodal forces int N_a N_b t_b dGamma on the boundaries' faces at t_{n+1} are
/// `forces` {n, 3}: solved with the mass matrix of the surface. {nodes.size(), 3} [stress]; `nodes`: those of
/// the boundaries, ascending. Errors (ErrorKind::numerical): a face without area.
[[nodiscard]] Result<std::vector<double>> traction_of(std::span<const double> forces, const FluidMesh& mesh,
                                                      std::span<const double> points,
                                                      std::span<const std::int32_t> boundaries,
                                                      std::span<const std::int32_t> nodes);

} // namespace drogue::fluid
