// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/verification/fluid_case.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/fem/quadrature.hpp"
#include "fluid_solver/probes.hpp"

namespace drogue::fluid::test {
namespace {

FluidMesh usable(mesh::Mesh file) {
  auto mesh = FluidMesh::create(std::move(file));
  EXPECT_TRUE(mesh.ok()) << (mesh.ok() ? "" : mesh.error().message);
  return std::move(mesh).value();
}

struct Barycentric {
  std::array<double, 4> N{};
  double weight = 0; ///< of sum 1
};

std::vector<Barycentric> cell_rule(int dimension) {
  std::vector<Barycentric> rule;
  if (dimension == 2)
    for (const auto& q : fem::surface_quadrature(mesh::ElementKind::tri3, 5))
      rule.push_back({{1 - q.xi - q.eta, q.xi, q.eta, 0}, 2 * q.weight});
  else
    for (const auto& q : fem::volume_quadrature(mesh::ElementKind::tet4, 5))
      rule.push_back({{1 - q.xi[0] - q.xi[1] - q.xi[2], q.xi[0], q.xi[1], q.xi[2]}, 6 * q.weight});
  return rule;
}

/// Calls f(weight, x, u, p) at the points of a rule over all cells.
template <class F>
void integrate(const FluidMesh& mesh, const FlowState& s, const F& f) {
  const auto rule = cell_rule(mesh.dimension);
  for (std::int32_t e = 0; e < mesh.cell_count(); ++e) {
    const double volume = cell_geometry(mesh, s.x, e).volume;
    for (const auto& [N, weight] : rule) {
      std::array<double, 3> x{};
      std::array<double, 3> u{};
      double p = 0;
      for (std::size_t a = 0; a < mesh.cell_nodes(); ++a) {
        const auto node = static_cast<std::size_t>(mesh.cell(e)[a]);
        for (std::size_t d = 0; d < 3; ++d) {
          x[d] += N[a] * s.x[3 * node + d];
          u[d] += N[a] * s.u[3 * node + d];
        }
        p += N[a] * s.p[node];
      }
      f(weight * volume, x, u, p);
    }
  }
}

/// Extreme of the parabola through three values where the middle one is the largest or smallest.
double vertex(double before, double here, double after) {
  const double curvature = before - 2 * here + after;
  const double slope = 0.5 * (after - before);
  return curvature == 0 ? here : here - 0.5 * slope * slope / curvature;
}

/// By how much the slab's mean pressure makes the first report's force larger than that at its end does.
std::array<double, 3> pressure_of_the_mean(FlowCase& flow) {
  const std::vector<double> mean = flow.solver().pressure_mean(), end = flow.solver().pressure_np1();
  const auto boundaries = boundary_indices(flow.mesh(), flow.settings().forces.front().boundaries);
  std::array<double, 3> force{};
  for (const BoundaryFace& face : flow.mesh().faces) {
    if (std::find(boundaries.begin(), boundaries.end(), face.boundary) == boundaries.end()) continue;
    const auto normal = area_vector(face, flow.state().x);
    for (const std::int32_t node : face.nodes())
      for (std::size_t d = 0; d < 3; ++d)
        force[d] += flow.settings().density * normal[d] / static_cast<double>(face.corners) *
                    (mean[static_cast<std::size_t>(node)] - end[static_cast<std::size_t>(node)]);
  }
  return force;
}

} // namespace

Settings flow_settings(double viscosity, double residual_tolerance) {
  Settings s;
  s.mesh = "of the test";
  s.density = 1;
  s.dynamic_viscosity = viscosity;
  s.newton = {residual_tolerance, 20, 0.5, 1, 20};
  s.linear = {1e-4, 400, 100};
  return s;
}

FlowCase::FlowCase(Settings settings, mesh::Mesh file)
    : settings_(std::move(settings)), mesh_(usable(std::move(file))), solver_(settings_, mesh_) {
  config::Report report;
  check_against_mesh(settings_, mesh_, report);
  EXPECT_TRUE(report.ok()) << (report.ok() ? "" : report.as_error().message);
}

std::vector<SurfaceForce> FlowCase::finish_step() {
  const auto report = solver_.newton(settings_.newton.max_iterations);
  EXPECT_TRUE(report.ok()) << (report.ok() ? "" : report.error().message);
  const auto last = solver_.finish();
  EXPECT_TRUE(last.ok() && last->converged) << "step " << state().step << ", residual " << last->residual;
  auto forces = surface_forces(settings_, mesh_, solver_);
  solver_.commit();
  return forces;
}

std::vector<SurfaceForce> FlowCase::step(const StepScheme& scheme, double dt) {
  EXPECT_TRUE(solver_.begin_step(scheme, dt).ok());
  return finish_step();
}

std::vector<SurfaceForce> FlowCase::step_to(const StepScheme& scheme, double dt,
                                            const std::vector<double>& x_np1,
                                            const std::vector<double>& wall_n,
                                            const std::vector<double>& wall_np1) {
  EXPECT_TRUE(solver_.begin_step(scheme, dt).ok());
  const auto set = solver_.set_end(x_np1, wall_n, wall_np1);
  EXPECT_TRUE(set.ok()) << (set.ok() ? "" : set.error().message);
  return finish_step();
}

std::vector<SurfaceForce> FlowCase::settle(double first_dt, double tolerance) {
  double dt = first_dt;
  for (int step = 0; step < 60; ++step) {
    const std::vector<double> before = state().u;
    auto forces = this->step({Formulation::semi_discrete}, dt);
    double change = 0;
    double largest = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      change = std::max(change, std::abs(state().u[i] - before[i]));
      largest = std::max(largest, std::abs(before[i]));
    }
    if (change < tolerance * largest && dt > 1e3 * first_dt) return forces;
    dt *= 2;
  }
  ADD_FAILURE() << "the flow does not become steady";
  return std::vector<SurfaceForce>(settings_.forces.size());
}

ForceHistory advance(FlowCase& flow, const StepScheme& scheme, double dt, int steps) {
  ForceHistory history;
  for (int k = 0; k < steps; ++k) {
    const SurfaceForce force = flow.step(scheme, dt).front();
    const auto later = pressure_of_the_mean(flow);
    for (std::size_t d = 0; d < 2; ++d) {
      history.reaction[d].push_back(force.reaction[d]);
      history.stress[d].push_back(force.total()[d] + later[d]);
    }
  }
  return history;
}

FieldErrors field_errors(const FluidMesh& mesh, const FlowState& state, const config::VectorExpression& u,
                         const config::Expression& p) {
  double volume = 0;
  double mean = 0;
  const auto pressure_error = [&](const std::array<double, 3>& x, double value) {
    return value - p(x[0], x[1], x[2], state.time);
  };
  integrate(mesh, state, [&](double w, const auto& x, const auto&, double value) {
    volume += w;
    mean += w * pressure_error(x, value);
  });
  mean /= volume;
  FieldErrors square;
  integrate(mesh, state, [&](double w, const auto& x, const auto& velocity, double value) {
    for (std::size_t d = 0; d < 3; ++d)
      square.velocity += w * std::pow(velocity[d] - u[d](x[0], x[1], x[2], state.time), 2);
    square.pressure += w * std::pow(pressure_error(x, value) - mean, 2);
  });
  return {std::sqrt(square.velocity), std::sqrt(square.pressure)};
}

std::vector<double> value_at(const FlowCase& flow, double x, double y, double z) {
  Settings s;
  s.probes = {{"point", {x, y, z}}};
  const auto probes = Probes::create(s.probes, flow.mesh());
  EXPECT_TRUE(probes.ok());
  return probes->values(flow.state().u, flow.state().p, flow.settings().density);
}

Periodic last_periods(const std::vector<double>& values, const std::vector<double>& marker, double dt,
                      int periods) {
  const std::size_t half = marker.size() / 2;
  const auto [low, high] =
      std::minmax_element(marker.begin() + static_cast<std::ptrdiff_t>(half), marker.end());
  const double middle = 0.5 * (*low + *high);
  std::vector<double> crossings; // in samples
  for (std::size_t i = half + 1; i < marker.size(); ++i)
    if (marker[i - 1] < middle && marker[i] >= middle)
      crossings.push_back(static_cast<double>(i) - (marker[i] - middle) / (marker[i] - marker[i - 1]));
  Periodic p;
  if (crossings.size() <= static_cast<std::size_t>(periods)) {
    ADD_FAILURE() << "only " << crossings.size() << " crossings in the second half of the history";
    return p;
  }
  const double last = crossings.back();
  const double first = crossings[crossings.size() - 1 - static_cast<std::size_t>(periods)];
  p.period = (last - first) * dt / periods;
  const auto begin = std::max<std::size_t>(1, static_cast<std::size_t>(first));
  const auto end = std::min(marker.size() - 1, static_cast<std::size_t>(last) + 1);
  double smallest = values[begin];
  p.largest = smallest;
  for (std::size_t i = begin; i < end; ++i) {
    const double v = vertex(values[i - 1], values[i], values[i + 1]);
    if (values[i] >= values[i - 1] && values[i] >= values[i + 1]) p.largest = std::max(p.largest, v);
    if (values[i] <= values[i - 1] && values[i] <= values[i + 1]) smallest = std::min(smallest, v);
    p.average += values[i] / static_cast<double>(end - begin);
  }
  p.mean = 0.5 * (p.largest + smallest);
  p.amplitude = 0.5 * (p.largest - smallest);
  return p;
}

} // namespace drogue::fluid::test
