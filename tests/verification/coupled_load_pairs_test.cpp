// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "tests/fluid_solver/box.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/fluid_case.hpp"
#include "tests/verification/layer_mesh.hpp"

/// Which rate of the wall goes with which load of a space-time slab: a frictionless wall y = H + a sin(kx)
/// sin(omega t) over a layer of ideal fluid, k = pi / L. It feels the pressure of the added mass,
///   p = rho a omega^2 coth(kH)/k sin(kx) sin(omega t).
namespace drogue::fluid::test {
namespace {

using drogue::test::verify;

constexpr double L = 1, H = 0.5, a = 1e-4, omega = 2 * std::numbers::pi, k = std::numbers::pi / L;

mesh::Mesh layer() {
  mesh::Mesh m;
  drogue::test::add_layer(m, L, 24, drogue::test::finer_towards(H, 0, 12), "floor", "top");
  return m;
}

Settings layer_settings(bool time_weight) {
  Settings s = flow_settings(1e-6, 1e-8);
  s.time_weight = time_weight;
  BoundarySettings top = boundary("top", Condition::no_slip);
  top.components = {false, true, false};
  s.boundaries = {top, boundary("floor", Condition::free_slip), boundary("ends", Condition::traction_free)};
  return s;
}

enum class Rate { structure, mesh }; // loop.wall_velocity of the coupler

/// 2/L int p sin(kx) dx along the wall, by trapezia.
double mode(const FlowCase& flow, const std::vector<double>& p) {
  const auto& x = flow.mesh().points;
  double sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (x[3 * i + 1] == H) sum += p[i] * std::sin(k * x[3 * i]) * 2 / 24;
  return sum;
}

/// Loads of the last two periods as multiples of the exact one: 1 is right, the imaginary part leads in
/// phase.
struct Answer {
  std::complex<double> end, mean, extrapolated; // the last from the means of two steps
};

Answer oscillate(Rate rate, int steps_a_period, bool time_weight) {
  FlowCase flow(layer_settings(time_weight), layer());
  const std::vector<double> X = flow.mesh().points;
  const double dt = 1.0 / steps_a_period;
  const auto displaced = [&](double t) {
    std::vector<double> x = X;
    for (std::size_t i = 0; i < x.size(); i += 3)
      x[i + 1] += a * X[i + 1] / H * std::sin(k * X[i]) * std::sin(omega * t);
    return x;
  };
  const auto wall = [&](double t) {
    std::vector<double> v(X.size(), 0.0);
    for (std::size_t i = 0; i < v.size(); i += 3)
      v[i + 1] = a * omega * std::sin(k * X[i]) * std::cos(omega * t);
    return v;
  };
  const double exact = a * omega * omega / (std::tanh(k * H) * k);
  Answer answer{};
  double last_mean = 0;
  for (int n = 0; n < 4 * steps_a_period; ++n) {
    const std::vector<double> x_n = displaced(n * dt), x_np1 = displaced((n + 1) * dt);
    std::vector<double> v_n = wall(n * dt), v_np1 = wall((n + 1) * dt);
    if (rate == Rate::mesh) {
      for (std::size_t i = 0; i < v_n.size(); ++i) v_n[i] = (x_np1[i] - x_n[i]) / dt;
      v_np1 = v_n;
    }
    FlowSolver& solver = flow.solver();
    EXPECT_TRUE(solver.begin_step(space_time, dt).ok() && solver.set_end(x_np1, v_n, v_np1).ok());
    const auto report = solver.newton(10);
    EXPECT_TRUE(report.ok() && solver.finish().ok());
    // The phase of the exact load at the end of the step, turned back.
    const std::complex<double> back = std::polar(1.0 / (steps_a_period * exact), -omega * (n + 1) * dt);
    const auto add = [&](std::complex<double>& to, double load) {
      to += load * back * std::complex<double>(0, 1);
    };
    if (n >= 2 * steps_a_period) {
      add(answer.end, mode(flow, solver.pressure_np1()));
      const double mean = mode(flow, solver.pressure_mean());
      add(answer.mean, mean);
      add(answer.extrapolated, 1.5 * mean - 0.5 * last_mean);
    }
    last_mean = mode(flow, solver.pressure_mean());
    solver.commit();
  }
  return answer;
}

/// |error| of the load relative to the exact one.
struct Errors {
  double end = 0, mean = 0, extrapolated = 0;
};
Errors errors(Rate rate, int steps_a_period, bool time_weight) {
  const Answer load = oscillate(rate, steps_a_period, time_weight);
  return {std::abs(load.end - 1.0), std::abs(load.mean - 1.0), std::abs(load.extrapolated - 1.0)};
}

/// Error at 24 and 48 steps a period, and the observed order.
void verify_pair(const std::string& name, double coarse, double fine, double largest, double order,
                 double margin) {
  verify("coupler/pair_" + name, "load_error_24", coarse, 0, largest);
  verify("coupler/pair_" + name, "load_error_48", fine, 0, largest * std::pow(0.5, order - margin));
  verify("coupler/pair_" + name, "order", std::log2(coarse / fine), order, margin);
}

TEST(LoadPairs, OverAPrescribedWall) {
  for (const bool time_weight : {true, false}) {
    const std::string suffix = time_weight ? "" : "_no_time_weight";
    const Errors structure[] = {errors(Rate::structure, 24, time_weight),
                                errors(Rate::structure, 48, time_weight)};
    const Errors mesh[] = {errors(Rate::mesh, 24, time_weight), errors(Rate::mesh, 48, time_weight)};
    verify_pair("structure_rate_extrapolated_mean" + suffix, structure[0].extrapolated,
                structure[1].extrapolated, 0.05, 2, 0.5);
    // Half a step late, omega dt/2 = 0.131 and 0.065, and a whole one.
    verify_pair("structure_rate_end_load" + suffix, structure[0].end, structure[1].end, 0.14, 1, 0.3);
    verify_pair("structure_rate_mean_load" + suffix, structure[0].mean, structure[1].mean, 0.14, 1, 0.3);
    verify_pair("mesh_rate_mean_load" + suffix, mesh[0].mean, mesh[1].mean, 0.27, 1, 0.3);
    // The pair that the coupler refuses: hardly any load, whatever the step.
    EXPECT_GT(mesh[0].end, 0.75);
    EXPECT_GT(mesh[1].end, 0.75);
  }
}

} // namespace
} // namespace drogue::fluid::test
