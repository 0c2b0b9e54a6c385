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
const FlowParameters parameters{.dt = 0.3, .nu = 0.02, .smagorinsky = 0.2, .lsic = true};

/// Coefficients recorded at the base state: what the tangent holds constant.
struct Frozen {
  Coefficients<double> k[2];
  Coefficients<double> operator()(int point, const TetGeometry<double>&, const double*,
                                  const double (*)[3]) const noexcept {
    return k[point];
  }
};
struct Recorder {
  StandardCoefficients standard{parameters};
  Frozen* frozen;
  Coefficients<double> operator()(int point, const TetGeometry<double>& g, const double* c,
                                  const double (*grad_u)[3]) const noexcept {
    return frozen->k[point] = standard(point, g, c, grad_u);
  }
};

template <class Values, int n, class Element>
double largest_tangent_error(Values in, Element&& element) {
  Frozen frozen;
  double r[4][n];
  std::vector<double> tangent(4 * n * 4 * n);
  element(in, Recorder{{parameters}, &frozen}, r, [&](int a, int b, const double* block) {
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) tangent[(n * a + i) * 4 * n + n * b + j] = block[n * j + i];
  });
  const double step = 1e-6;
  double worst = 0;
  double scale = 0;
  for (int b = 0; b < 4; ++b)
    for (int j = 0; j < n; ++j) {
      double plus[4][n];
      double minus[4][n];
      const double keep = in.w[b][j];
      auto ignore = [](int, int, const double*) {};
      in.w[b][j] = keep + step;
      element(in, frozen, plus, ignore);
      in.w[b][j] = keep - step;
      element(in, frozen, minus, ignore);
      in.w[b][j] = keep;
      for (int a = 0; a < 4; ++a)
        for (int i = 0; i < n; ++i) {
          const double exact = tangent[(n * a + i) * 4 * n + n * b + j];
          worst = std::max(worst, std::abs((plus[a][i] - minus[a][i]) / (2 * step) - exact));
          scale = std::max(scale, std::abs(exact));
        }
    }
  return worst / scale;
}

template <class Values>
Values random_values(int unknowns) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Values in;
  for (int a = 0; a < 4; ++a) {
    for (int d = 0; d < 3; ++d) in.u_n[a][d] = uniform(generator);
    for (int i = 0; i < unknowns; ++i) in.w[a][i] = uniform(generator);
  }
  return in;
}

TEST(SemiDiscreteElement, TangentMatchesFiniteDifferencesWithFrozenCoefficients) {
  auto in = random_values<SemiDiscreteValues<double>>(4);
  for (int a = 0; a < 4; ++a)
    for (int d = 0; d < 3; ++d) {
      in.x[a][d] = corners[a][d];
      in.f[a][d] = 0.3 * a - d;
    }
  const double error = largest_tangent_error<SemiDiscreteValues<double>, 4>(
      in, [](const auto& v, const auto& rule, auto r, auto&& sink) {
        semi_discrete_element<true>(v, parameters.dt, rule, r, sink);
      });
  EXPECT_LT(error, 1e-8);
}

SpaceTimeValues<double> slab() {
  auto in = random_values<SpaceTimeValues<double>>(8);
  for (int a = 0; a < 4; ++a)
    for (int d = 0; d < 3; ++d) {
      in.x_n[a][d] = corners[a][d];
      in.x_np1[a][d] = corners[a][d] + 0.05 * std::sin(3.0 * a + d);
      in.f_n[a][d] = 0.2 * a;
      in.f_np1[a][d] = -0.4 * d;
    }
  return in;
}

TEST(SpaceTimeElement, TangentMatchesFiniteDifferencesWithFrozenCoefficients) {
  const double error = largest_tangent_error<SpaceTimeValues<double>, 8>(
      slab(), [](const auto& v, const auto& rule, auto r, auto&& sink) {
        space_time_element<true>(v, parameters.dt, rule, r, sink);
      });
  EXPECT_LT(error, 1e-8);
}

TEST(SpaceTimeElement, BatchOfEightGivesWhatEachElementGives) {
  const SpaceTimeValues<double> in = slab();
  SpaceTimeValues<Batch> batch;
  const auto fill = [](auto& to, const auto& from) {
    for (int a = 0; a < 4; ++a)
      for (std::size_t i = 0; i < std::extent_v<std::remove_reference_t<decltype(from)>, 1>; ++i)
        for (int l = 0; l < batch_size; ++l) to[a][i][l] = from[a][i] * (1 + 0.01 * l);
  };
  fill(batch.x_n, in.x_n);
  fill(batch.x_np1, in.x_np1);
  fill(batch.u_n, in.u_n);
  fill(batch.f_n, in.f_n);
  fill(batch.f_np1, in.f_np1);
  fill(batch.w, in.w);
  Batch r8[4][8];
  const auto ignore = [](int, int, const auto*) {};
  space_time_element<false>(batch, parameters.dt, StandardCoefficients{parameters}, r8, ignore);
  for (int l = 0; l < batch_size; ++l) {
    SpaceTimeValues<double> one = in;
    const auto scale = [&](auto& array) {
      for (auto& row : array)
        for (double& value : row) value *= 1 + 0.01 * l;
    };
    scale(one.x_n), scale(one.x_np1), scale(one.u_n), scale(one.f_n), scale(one.f_np1), scale(one.w);
    double r[4][8];
    space_time_element<false>(one, parameters.dt, StandardCoefficients{parameters}, r, ignore);
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 8; ++i) EXPECT_NEAR(r8[a][i][l], r[a][i], 1e-12);
  }
}

TEST(Stabilisation, LimitsOfTau) {
  const TetGeometry<double> geometry = tet_geometry(corners);
  const double grad_u[3][3] = {};
  const double h = element_length(geometry.volume);
  const double rest[3] = {0, 0, 0};
  const double wind[3] = {1, 2, 3};
  const auto rule = [](double dt, double nu) { return StandardCoefficients{{.dt = dt, .nu = nu}}; };
  EXPECT_NEAR(rule(1e-6, 1e-3)(0, geometry, wind, grad_u).tau, 0.5e-6, 1e-10);
  EXPECT_NEAR(rule(1e9, 10.0)(0, geometry, rest, grad_u).tau, h * h / 40, 1e-9);
  EXPECT_EQ(rule(0.1, 0.0)(0, geometry, rest, grad_u).tau_lsic, 0.0);
  const double far[3] = {1e5, 0, 0};
  const Coefficients<double> k = rule(1e9, 1e-6)(0, geometry, far, grad_u);
  EXPECT_NEAR(k.tau_lsic, k.tau * 1e10, 1e-3 * k.tau * 1e10); // h_ugn/(2|c|) |c|^2
}

} // namespace
} // namespace drogue::fluid
