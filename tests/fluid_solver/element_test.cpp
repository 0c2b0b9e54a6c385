// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "fluid_solver/semi_discrete_element.hpp"
#include "fluid_solver/space_time_element.hpp"

namespace drogue::fluid {
namespace {

constexpr double corners[4][3] = {{0.1, 0, 0}, {1, 0.1, 0.05}, {0.2, 0.9, -0.1}, {0.15, 0.2, 1.1}};
const FlowParameters parameters{
    .dt = 0.3, .nu = 0.02, .smagorinsky = 0.2, .lsic = true, .tau_dt = 0.3, .viscous_residual = true};

/// Coefficients recorded at the base state: what the tangent holds constant.
struct Frozen {
  Coefficients<double> k[3];
  template <int dim>
  Coefficients<double> operator()(int point, const SimplexGeometry<dim, double>&, const double*,
                                  const double (*)[dim]) const noexcept {
    return k[point];
  }
};
struct Recorder {
  StandardCoefficients standard{parameters};
  Frozen* frozen;
  template <int dim>
  Coefficients<double> operator()(int point, const SimplexGeometry<dim, double>& g, const double* c,
                                  const double (*grad_u)[dim]) const noexcept {
    return frozen->k[point] = standard(point, g, c, grad_u);
  }
};

template <class Values, int dim, int n, class Element>
double largest_tangent_error(Values in, Element&& element) {
  constexpr int nodes = dim + 1;
  Frozen frozen;
  double r[nodes][n];
  std::vector<double> tangent(nodes * n * nodes * n);
  element(in, Recorder{{parameters}, &frozen}, r, [&](int a, int b, const double* block) {
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) tangent[(n * a + i) * nodes * n + n * b + j] = block[n * j + i];
  });
  const double step = 1e-6;
  double worst = 0;
  double scale = 0;
  for (int b = 0; b < nodes; ++b)
    for (int j = 0; j < n; ++j) {
      double plus[nodes][n];
      double minus[nodes][n];
      const double keep = in.w[b][j];
      auto ignore = [](int, int, const double*) {};
      in.w[b][j] = keep + step;
      element(in, frozen, plus, ignore);
      in.w[b][j] = keep - step;
      element(in, frozen, minus, ignore);
      in.w[b][j] = keep;
      for (int a = 0; a < nodes; ++a)
        for (int i = 0; i < n; ++i) {
          const double exact = tangent[(n * a + i) * nodes * n + n * b + j];
          worst = std::max(worst, std::abs((plus[a][i] - minus[a][i]) / (2 * step) - exact));
          scale = std::max(scale, std::abs(exact));
        }
    }
  return worst / scale;
}

template <int rows, int columns>
void fill_at_random(std::mt19937& generator, double (&values)[rows][columns]) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (auto& row : values)
    for (double& value : row) value = uniform(generator);
}

template <int dim>
SemiDiscreteValues<dim, double> instant_values() {
  std::mt19937 generator(7);
  SemiDiscreteValues<dim, double> in;
  fill_at_random(generator, in.stress);
  fill_at_random(generator, in.history);
  fill_at_random(generator, in.f);
  fill_at_random(generator, in.w);
  for (int a = 0; a <= dim; ++a)
    for (int d = 0; d < dim; ++d) in.x[a][d] = corners[a][d];
  return in;
}

template <int dim>
SpaceTimeValues<dim, double> slab() {
  std::mt19937 generator(7);
  SpaceTimeValues<dim, double> in;
  fill_at_random(generator, in.stress_n);
  fill_at_random(generator, in.stress_np1);
  fill_at_random(generator, in.u_n);
  fill_at_random(generator, in.f_n);
  fill_at_random(generator, in.f_np1);
  fill_at_random(generator, in.w);
  for (int a = 0; a <= dim; ++a)
    for (int d = 0; d < dim; ++d) {
      in.x_n[a][d] = corners[a][d];
      in.x_np1[a][d] = corners[a][d] + 0.05 * std::sin(3.0 * a + d);
    }
  return in;
}

template <int dim>
double semi_discrete_tangent_error() {
  return largest_tangent_error<SemiDiscreteValues<dim, double>, dim, 4>(
      instant_values<dim>(), [](const auto& v, const auto& rule, auto r, auto&& sink) {
        Instant<dim, double> s;
        semi_discrete_residual(v, 1.4 / parameters.dt, parameters, rule, r, s);
        semi_discrete_tangent(s, 1.4 / parameters.dt, sink);
      });
}

template <int dim, int time_points>
double space_time_tangent_error() {
  return largest_tangent_error<SpaceTimeValues<dim, double>, dim, 8>(
      slab<dim>(), [](const auto& v, const auto& rule, auto r, auto&& sink) {
        SlabInstants<dim, time_points, double> s;
        space_time_residual<time_points>(v, parameters, rule, r, s);
        space_time_tangent(s, parameters.dt, sink);
      });
}

TEST(SemiDiscreteElement, TangentMatchesFiniteDifferencesWithFrozenCoefficients) {
  EXPECT_LT(semi_discrete_tangent_error<2>(), 1e-8);
  EXPECT_LT(semi_discrete_tangent_error<3>(), 1e-8);
}

TEST(SpaceTimeElement, TangentMatchesFiniteDifferencesWithFrozenCoefficients) {
  EXPECT_LT((space_time_tangent_error<2, 2>()), 1e-8);
  EXPECT_LT((space_time_tangent_error<3, 2>()), 1e-8);
}

TEST(SpaceTimeElement, TangentWithThreeTimePointsMatchesToo) {
  EXPECT_LT((space_time_tangent_error<2, 3>()), 1e-8);
  EXPECT_LT((space_time_tangent_error<3, 3>()), 1e-8);
}

/// Lane l of a batch is the element made 1 % larger l times.
template <int rows, int columns>
void fill_lanes(Batch (&to)[rows][columns], const double (&from)[rows][columns]) {
  for (int a = 0; a < rows; ++a)
    for (int i = 0; i < columns; ++i)
      for (int l = 0; l < batch_size; ++l) to[a][i][l] = from[a][i] * (1 + 0.01 * l);
}

TEST(SpaceTimeElement, BatchesGiveWhatEachElementGives) {
  const SpaceTimeValues<3, double> in = slab<3>();
  SpaceTimeValues<3, Batch> batch;
  fill_lanes(batch.x_n, in.x_n);
  fill_lanes(batch.x_np1, in.x_np1);
  fill_lanes(batch.u_n, in.u_n);
  fill_lanes(batch.f_n, in.f_n);
  fill_lanes(batch.f_np1, in.f_np1);
  fill_lanes(batch.w, in.w);
  fill_lanes(batch.stress_n, in.stress_n);
  fill_lanes(batch.stress_np1, in.stress_np1);
  const StandardCoefficients rule{parameters};
  Batch r8[4][8];
  SlabInstants<3, 2, Batch> s8;
  space_time_residual(batch, parameters, rule, r8, s8);
  SlabInstants<3, 2, Floats> s16;
  narrow(s8, 0, s16);
  narrow(s8, 1, s16);
  std::vector<Floats> tangent16;
  space_time_tangent(s16, parameters.dt, [&](int, int, const Floats* block) {
    tangent16.insert(tangent16.end(), block, block + 64);
  });
  for (int l = 0; l < batch_size; ++l) {
    SpaceTimeValues<3, double> one = in;
    const auto scale = [&](auto& array) {
      for (auto& row : array)
        for (double& value : row) value *= 1 + 0.01 * l;
    };
    scale(one.x_n), scale(one.x_np1), scale(one.u_n), scale(one.f_n), scale(one.f_np1), scale(one.w);
    scale(one.stress_n), scale(one.stress_np1);
    double r[4][8];
    SlabInstants<3, 2, double> s;
    space_time_residual(one, parameters, rule, r, s);
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 8; ++i) EXPECT_NEAR(r8[a][i][l], r[a][i], 1e-12);
    std::size_t k = 0;
    double largest = 0;
    double difference = 0; // of the tangent in single precision
    space_time_tangent(s, parameters.dt, [&](int, int, const double* block) {
      for (int i = 0; i < 64; ++i, ++k) {
        largest = std::max(largest, std::abs(block[i]));
        for (int half = 0; half < 2; ++half)
          difference =
              std::max(difference, std::abs(static_cast<double>(tangent16[k][8 * half + l]) - block[i]));
      }
    });
    EXPECT_GT(largest, 0);
    EXPECT_LT(difference, 1e-6 * largest);
  }
}

TEST(Stabilisation, LimitsOfTau) {
  const SimplexGeometry<3, double> geometry = simplex_geometry(corners);
  const double grad_u[3][3] = {};
  const double h = element_length<3>(geometry.volume);
  const double rest[3] = {0, 0, 0};
  const double wind[3] = {1, 2, 3};
  const auto rule = [](double dt, double nu) {
    return StandardCoefficients{{.dt = dt, .nu = nu, .tau_dt = dt}};
  };
  EXPECT_NEAR(rule(1e-6, 1e-3)(0, geometry, wind, grad_u).tau, 0.5e-6, 1e-10);
  EXPECT_NEAR(rule(1e9, 10.0)(0, geometry, rest, grad_u).tau, h * h / 40, 1e-9);
  EXPECT_EQ(rule(0.1, 0.0)(0, geometry, rest, grad_u).tau_lsic, 0.0);
  const double far[3] = {1e5, 0, 0};
  const Coefficients<double> k = rule(1e9, 1e-6)(0, geometry, far, grad_u);
  EXPECT_NEAR(k.tau_lsic, k.tau * 1e10, 1e-3 * k.tau * 1e10); // h_ugn/(2|c|) |c|^2
}

} // namespace
} // namespace drogue::fluid
