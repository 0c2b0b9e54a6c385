// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/base/result.hpp"
#include "common/la_krylov/krylov_solver.hpp"
#include "fluid_solver/boundary_conditions.hpp"
#include "fluid_solver/fluid_mesh.hpp"
#include "fluid_solver/settings.hpp"
#include "fluid_solver/step_data.hpp"

namespace drogue::fluid {

/// The nonlinear algebraic system of one step, distributed over the ranks: residual, Jacobian, linear solves.
///
/// Scaling: continuity rows are multiplied and pressures divided by a reference speed U, so that every row is
/// a force over density and every unknown a velocity, and norms compare like with like.
///
/// Preconditioner, z = M^-1 r: 1. z = ILU^-1 r by node blocks, block Jacobi between ranks; 2. the defect of
/// the pressure rows s = (r - A z)_p; 3. z_p += K^-1 W^-1 s, K the Laplacian of linear elements (one AMG
/// cycle, set up once, on the file's mesh) and W the time matrix of the pressure Schur complement S ~ K (x)
/// W.
class FlowSystem {
 public:
  virtual ~FlowSystem() = default;
  /// 4 or 8.
  [[nodiscard]] virtual int unknowns() const = 0;
  /// Sets dt and U; `convection` false leaves the convective terms out. The Jacobian must be evaluated
  /// afterwards.
  virtual void begin_step(double dt, double reference_speed, bool convection) = 0;
  /// Residual (and Jacobian with its factorisation) at data.unknowns, which must satisfy the constraints.
  /// Returns the scaled norm over the free rows. @note Collective
  [[nodiscard]] virtual Result<double> evaluate(const StepData& data, bool jacobian) = 0;
  /// Unscaled residual of the last evaluate, constrained rows included, own rows {rows, unknowns}: there it
  /// is the reaction of the boundary.
  [[nodiscard]] virtual std::span<const double> residual() const = 0;
  [[nodiscard]] virtual la::RowRange own_rows() const = 0;
  /// Solves J dw = -residual and adds dw to `unknowns`, on every rank. @note Collective
  [[nodiscard]] virtual Result<la::Outcome> solve_and_add(std::span<double> unknowns) = 0;
};

/// @note Collective
[[nodiscard]] Result<std::unique_ptr<FlowSystem>> make_flow_system(Formulation formulation,
                                                                   const Settings& settings,
                                                                   const FluidMesh& mesh,
                                                                   const VelocityConstraints& constraints);

} // namespace drogue::fluid
