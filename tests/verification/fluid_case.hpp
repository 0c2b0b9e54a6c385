// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "fluid_solver/flow_solver.hpp"
#include "fluid_solver/forces.hpp"

/// Flows that the verification tests set up and step themselves.
namespace drogue::fluid::test {

inline constexpr StepScheme semi_discrete{Formulation::semi_discrete, 2, 2};
inline constexpr StepScheme space_time{Formulation::dsd_sst, 1, 2};

/// Density 1, one Jacobian a step as long as Newton's iterations converge with it, no boundary conditions
/// yet.
[[nodiscard]] Settings flow_settings(double viscosity, double residual_tolerance);

/// A mesh, its settings and its flow. Not movable: the solver refers to the other two.
class FlowCase {
 public:
  /// Requires a usable mesh and a condition on every boundary; the test fails otherwise.
  FlowCase(Settings settings, mesh::Mesh file);
  FlowCase(const FlowCase&) = delete;
  FlowCase& operator=(const FlowCase&) = delete;

  [[nodiscard]] const Settings& settings() const { return settings_; }
  [[nodiscard]] const FluidMesh& mesh() const { return mesh_; }
  [[nodiscard]] FlowSolver& solver() { return solver_; }
  [[nodiscard]] const FlowState& state() const { return solver_.state(); }

  /// One step on the mesh as it lies. Returns the forces of the settings' reports; the test fails where
  /// Newton does not converge.
  std::vector<SurfaceForce> step(const StepScheme& scheme, double dt);
  /// One step to the mesh x_np1, its walls moving with `wall_n` and `wall_np1`; all {n, 3}.
  std::vector<SurfaceForce> step_to(const StepScheme& scheme, double dt, const std::vector<double>& x_np1,
                                    const std::vector<double>& wall_n, const std::vector<double>& wall_np1);
  /// Steps of growing length until the velocity changes by less than `tolerance` of its largest value; the
  /// forces of the last.
  std::vector<SurfaceForce> settle(double first_dt, double tolerance = 1e-7);

 private:
  std::vector<SurfaceForce> finish_step();

  Settings settings_;
  FluidMesh mesh_;
  FlowSolver solver_;
};

/// Force of the settings' first report at every step: by the nodal reaction, in DSD/SST the mean of the slab,
/// and by the stress on the surface, with the pressure of the slab's mean: that at its end alone lacks the
/// viscous term that linear elements leave out of the time-weighted residual (fluid.proto, time_weight).
struct ForceHistory {
  std::array<std::vector<double>, 2> reaction; ///< along x, y
  std::array<std::vector<double>, 2> stress;   ///< along x, y
};
[[nodiscard]] ForceHistory advance(FlowCase& flow, const StepScheme& scheme, double dt, int steps);

/// L2 norms of what differs from the exact fields at the state's time, pressures up to a constant.
struct FieldErrors {
  double velocity = 0;
  double pressure = 0;
};
[[nodiscard]] FieldErrors field_errors(const FluidMesh& mesh, const FlowState& state,
                                       const config::VectorExpression& u, const config::Expression& p);

/// Linear interpolation of the committed flow at a point: u_x, u_y, u_z, p.
[[nodiscard]] std::vector<double> value_at(const FlowCase& flow, double x, double y, double z = 0);

/// A periodic history sampled at equal steps, by its last whole periods.
struct Periodic {
  double mean = 0;      ///< (max + min) / 2
  double amplitude = 0; ///< (max - min) / 2
  double largest = 0;
  double average = 0; ///< of the period
  double period = 0;
};
/// Extremes by parabolas through the samples; the period from upward crossings of the mean of the `marker`
/// (the lift, say) over its last `periods` periods. The test fails when there are fewer.
[[nodiscard]] Periodic last_periods(const std::vector<double>& values, const std::vector<double>& marker,
                                    double dt, int periods = 1);

} // namespace drogue::fluid::test
