// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/quadrature.hpp"

#include <cassert>
#include <cmath>
#include <numbers>

#include "common/fem/shape.hpp"

namespace drogue::fem {
namespace {

/// Adds the three points that permute the barycentric coordinates (a, a, 1 - 2 a).
void add_orbit(std::vector<SurfacePoint>& rule, double a, double weight) {
  const double b = 1 - 2 * a;
  rule.push_back({a, a, weight});
  rule.push_back({b, a, weight});
  rule.push_back({a, b, weight});
}

std::vector<SurfacePoint> triangle_rule(int degree) {
  std::vector<SurfacePoint> rule;
  if (degree <= 1) {
    rule.push_back({1.0 / 3, 1.0 / 3, 0.5});
  } else if (degree == 2) {
    add_orbit(rule, 1.0 / 6, 1.0 / 6);
  } else if (degree <= 4) { // six points: roots of the moment equations of degree four in closed form
    const double s10 = std::sqrt(10.0), r = std::sqrt(38 - 44 * std::sqrt(0.4));
    const double q = std::sqrt(213125 - 53320 * s10);
    add_orbit(rule, (8 - s10 + r) / 18, (620 + q) / 7440);
    add_orbit(rule, (8 - s10 - r) / 18, (620 - q) / 7440);
  } else if (degree == 5) { // seven points, Radon
    const double s = std::sqrt(15.0);
    rule.push_back({1.0 / 3, 1.0 / 3, 9.0 / 80});
    add_orbit(rule, (6 - s) / 21, (155 - s) / 2400);
    add_orbit(rule, (6 + s) / 21, (155 + s) / 2400);
  } else { // collapsed product: one degree is spent on the Jacobian 1 - u
    const GaussRule g = gauss_legendre((degree + 1) / 2 + 1);
    for (std::size_t i = 0; i < g.points.size(); ++i)
      for (std::size_t j = 0; j < g.points.size(); ++j) {
        const double u = 0.5 * (1 + g.points[i]), v = 0.5 * (1 + g.points[j]);
        rule.push_back({u, v * (1 - u), 0.25 * g.weights[i] * g.weights[j] * (1 - u)});
      }
  }
  return rule;
}

} // namespace

GaussRule gauss_legendre(int n) {
  assert(n >= 1 && n <= 32);
  GaussRule rule;
  for (int i = 0; i < n; ++i) { // Newton on the Legendre polynomial P_n from Chebyshev's guess
    double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5));
    double derivative = 1;
    for (int iteration = 0; iteration < 50; ++iteration) {
      double p0 = 1, p1 = x;
      for (int k = 2; k <= n; ++k) {
        const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1;
        p1 = p2;
      }
      derivative = n * (x * p1 - p0) / (x * x - 1);
      const double dx = p1 / derivative;
      x -= dx;
      if (std::abs(dx) < 1e-16) break;
    }
    rule.points.push_back(x);
    rule.weights.push_back(2 / ((1 - x * x) * derivative * derivative));
  }
  return rule;
}

std::vector<SurfacePoint> surface_quadrature(mesh::ElementKind kind, int degree) {
  assert(degree >= 1 && degree <= 20);
  if (!is_quadrilateral(kind)) return triangle_rule(degree);
  const GaussRule g = gauss_legendre(degree / 2 + 1);
  std::vector<SurfacePoint> rule;
  for (std::size_t i = 0; i < g.points.size(); ++i)
    for (std::size_t j = 0; j < g.points.size(); ++j)
      rule.push_back({g.points[i], g.points[j], g.weights[i] * g.weights[j]});
  return rule;
}

} // namespace drogue::fem
