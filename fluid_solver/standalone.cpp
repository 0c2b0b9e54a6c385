// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/standalone.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include <unistd.h>

#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "common/la_krylov/session.hpp"
#include "fluid_solver/flow_remesher.hpp"

namespace drogue::fluid {
namespace {

/// Displaced points, and their velocity by central differences over a thousandth of the step.
struct Motion {
  std::vector<double> points;
  std::vector<double> velocity;
};

Motion prescribed(const config::VectorExpression& d, std::span<const double> reference, double t, double dt) {
  Motion m{{reference.begin(), reference.end()}, std::vector<double>(reference.size(), 0.0)};
  const double e = 1e-3 * dt;
  for (std::size_t k = 0; k < 3; ++k) {
    if (d[k].is_zero()) continue;
    for (std::size_t i = 0; i < reference.size(); i += 3) {
      const double x = reference[i];
      const double y = reference[i + 1];
      const double z = reference[i + 2];
      m.points[i + k] += d[k](x, y, z, t);
      m.velocity[i + k] = (d[k](x, y, z, t + e) - d[k](x, y, z, t - e)) / (2 * e);
    }
  }
  return m;
}

/// Where the nodes started, to which the prescribed motion refers.
struct Start {
  std::vector<double> points; ///< {n, 3}
  /// What the nodes of a mesh that has replaced the first one are away from the prescribed motion of their
  /// starts, as these are interpolated: zero on the boundary. Empty: not replaced.
  std::vector<double> offset;
};

Start start_of_replacement(const FluidMesh& mesh, const std::optional<config::VectorExpression>& motion,
                           double t) {
  const std::vector<double> moved =
      mesh.reordered_from_file(mesh.file.node_fields.at(start_displacement_name).values, 3);
  Start start{mesh.points, mesh.points};
  for (std::size_t i = 0; i < moved.size(); ++i) start.points[i] -= moved[i];
  const Motion now = motion ? prescribed(*motion, start.points, t, 1) : Motion{start.points, {}};
  for (std::size_t i = 0; i < moved.size(); ++i) start.offset[i] -= now.points[i];
  return start;
}

Result<void> move_mesh(const PhaseSettings& phase, double dt, const Start& start, FlowSolver& solver) {
  if (!phase.mesh_displacement) {
    const std::vector<double> rest(start.points.size(), 0.0);
    return solver.set_end(solver.state().x, rest, rest);
  }
  const double t = solver.state().time;
  const Motion begin = prescribed(*phase.mesh_displacement, start.points, t, dt);
  Motion end = prescribed(*phase.mesh_displacement, start.points, t + dt, dt);
  for (std::size_t i = 0; i < start.offset.size(); ++i) end.points[i] += start.offset[i];
  return solver.set_end(end.points, begin.velocity, end.velocity);
}

class Progress {
 public:
  explicit Progress(int steps) : steps_(steps), terminal_(isatty(STDERR_FILENO) != 0) {}
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { // what follows starts on a line of its own
    if (terminal_ && done_ > 0 && done_ < steps_) fmt::print(stderr, "\n");
  }

  void step(const FlowState& state, const StepFigures& f, const Settings& settings) {
    ++done_;
    const double passed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    std::string line = fmt::format("step {}/{} t {:.5g}  newton {} residual {:.1e}{}  gmres {}{}  cfl {:.2f}",
                                   done_, steps_, state.time, f.newton.iterations, f.newton.residual,
                                   f.newton.converged ? "" : " (not converged)", f.newton.linear_iterations,
                                   f.newton.linear_converged ? "" : " (not converged)", f.cfl);
    for (std::size_t i = 0; i < f.forces.size() && i < 2; ++i) {
      const auto& force = f.forces[i];
      const double scale = settings.forces[i].reference_force > 0 ? settings.forces[i].reference_force : 1;
      line += fmt::format("  {} ({:.3f}, {:.3f}, {:.3f})", settings.forces[i].name,
                          (force.pressure[0] + force.viscous[0]) / scale,
                          (force.pressure[1] + force.viscous[1]) / scale,
                          (force.pressure[2] + force.viscous[2]) / scale);
    }
    line +=
        fmt::format("  {:.2f} s a step, {:.0f} s left", passed / done_, passed / done_ * (steps_ - done_));
    if (terminal_)
      fmt::print(stderr, "\r\033[K{}{}", line, done_ == steps_ ? "\n" : "");
    else
      spdlog::info("{}", line);
  }

 private:
  int steps_;
  int done_ = 0;
  bool terminal_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

Result<StepFigures> attempt(const PhaseSettings& phase, double dt, const Case& input, const Start& start,
                            FlowRun& run) {
  FlowSolver& solver = run.solver();
  const NewtonSettings& newton = input.settings.newton;
  DROGUE_TRY(solver.begin_step({phase.formulation, phase.time_order, phase.time_points}, dt));
  DROGUE_TRY(move_mesh(phase, dt, start, solver));
  if (const auto done = solver.newton(newton.max_iterations); !done) return done.error();
  return run.finish_step(true, newton.failure_tolerance);
}

/// A step; one that fails numerically is taken in two halves, and these again.
Result<StepFigures> one_step(const PhaseSettings& phase, double dt, int halvings, const Case& input,
                             const Start& start, FlowRun& run) {
  auto done = attempt(phase, dt, input, start, run);
  if (done || done.error().kind != ErrorKind::numerical || halvings == 0) return done;
  if (la::rank() == 0)
    spdlog::warn("the step to t = {:.6g} failed and is taken in halves: {}", run.solver().state().time + dt,
                 done.error().message);
  const auto half = one_step(phase, 0.5 * dt, halvings - 1, input, start, run);
  return half ? one_step(phase, 0.5 * dt, halvings - 1, input, start, run) : half;
}

/// Largest change of a velocity in a step over the largest speed and the step [1/time].
double rate_of_change(const std::vector<double>& before, const std::vector<double>& after, double dt) {
  double change = 0;
  double speed = 0;
  for (std::size_t i = 0; i < after.size(); ++i) {
    change = std::max(change, std::fabs(after[i] - before[i]));
    speed = std::max(speed, std::fabs(after[i]));
  }
  return speed > 0 ? change / (speed * dt) : 0;
}

/// All phases; stops between two steps when a signal has come.
Result<void> all_steps(const Case& input, FlowRun& run, FlowRemesher& remesher) {
  Start start{input.mesh.points, {}};
  int steps = 0;
  for (const PhaseSettings& phase : input.settings.phases) steps += phase.steps;
  Progress progress(steps);
  int done = 0;
  for (const PhaseSettings& phase : input.settings.phases)
    for (int k = 0; k < phase.steps; ++k) {
      const FlowState& state = run.solver().state();
      const std::vector<double> before = state.u;
      const auto figures = one_step(phase, phase.step, input.settings.newton.max_halvings, input, start, run);
      if (!figures) {
        Error error = figures.error();
        error.message = fmt::format("step {} to t = {:.6g} failed: {}", state.step + 1,
                                    state.time + phase.step, error.message);
        return error;
      }
      ++done;
      if (la::rank() == 0) progress.step(state, *figures, input.settings);
      if (!la::on_every_rank(!interrupted()) && done < steps)
        return Error{ErrorKind::interrupted,
                     fmt::format("interrupted after step {} at t = {:.6g}", state.step, state.time)};
      if (phase.steady_tolerance > 0 &&
          rate_of_change(before, state.u, phase.step) <= phase.steady_tolerance) {
        if (la::rank() == 0) spdlog::info("steady after step {} at t = {:.6g}", state.step, state.time);
        done += phase.steps - k - 1;
        break;
      }
      const auto replaced = remesher.after_step(run, start.points);
      if (!replaced) return replaced.error();
      if (*replaced)
        start = start_of_replacement(input.mesh, phase.mesh_displacement, run.solver().state().time);
    }
  return {};
}

} // namespace

Result<void> run_standalone(Case& input, const std::filesystem::path& remesh_program) {
  FlowRun run(input);
  FlowRemesher remesher(input, remesh_program);
  DROGUE_TRY(run.start());
  DROGUE_TRY(run.open_results(input.settings.output.directory));
  Result<void> outcome = all_steps(input, run, remesher);
  // What was reached is kept, whatever ended the run.
  DROGUE_TRY(run.write_last_fields());
  if (input.settings.final_state) DROGUE_TRY(run.write_state(*input.settings.final_state));
  if (outcome) return outcome;
  Error error = outcome.error();
  const FlowState& state = run.solver().state();
  if (input.settings.final_state)
    error.message += fmt::format("; the state after step {} at t = {:.6g} is in {}", state.step, state.time,
                                 input.settings.final_state->string());
  return error;
}

} // namespace drogue::fluid
