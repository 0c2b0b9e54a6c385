// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/t10_fluid.hpp"

/// Twelve shapes of the T-10's canopy [ft], from inflated to collapsed.
namespace drogue::test {

struct T10Shape {
  std::string name;
  /// Of the cloth in the gores: the part of its length that bulges, see inflated_displacement().
  double fullness = 0.35;
  /// Where a point of the inflated canopy goes; `s` is its cloth coordinate.
  std::function<meshing::Point(const meshing::Point& x, double s)> move;
};

inline std::vector<T10Shape> t10_shapes() {
  using meshing::Point;
  const auto turned_about_y = [](const Point& x, double angle) {
    return Point(std::cos(angle) * x.x() + std::sin(angle) * x.z(), x.y(),
                 std::cos(angle) * x.z() - std::sin(angle) * x.x());
  };
  const auto about_z = [](const Point& x, double angle) {
    return Point(std::cos(angle) * x.x() - std::sin(angle) * x.y(),
                 std::sin(angle) * x.x() + std::cos(angle) * x.y(), x.z());
  };
  const auto across = [](const Point& x, double factor_x, double factor_y) {
    return Point(factor_x * x.x(), factor_y * x.y(), x.z());
  };
  // The flank at x > 0 pushed in by up to `depth`.
  const auto dented = [](const Point& x, double depth) {
    const Point from = x - Point(11, 0, -2);
    return Point(x.x() - depth * std::exp(-from.squaredNorm() / 36), x.y(), x.z());
  };
  return {
      {"inflated", 0.35, [](const Point& x, double) { return x; }},
      {"tilted_30_degrees", 0.35,
       [=](const Point& x, double) { return turned_about_y(x, std::numbers::pi / 6); }},
      {"wider_by_a_tenth", 0.35, [=](const Point& x, double) { return across(x, 1.1, 1.1); }},
      {"narrower_by_a_tenth", 0.35, [=](const Point& x, double) { return across(x, 0.9, 0.9); }},
      {"squeezed_to_six_tenths", 0.35, [=](const Point& x, double) { return across(x, 0.6, 1.2); }},
      {"sheared", 0.35, [](const Point& x, double) { return Point(x.x() + 0.3 * x.z(), x.y(), x.z()); }},
      {"twisted_20_degrees", 0.35,
       [=](const Point& x, double) { return about_z(x, std::numbers::pi / 9 * (x.z() - 6) / 12); }},
      {"gores_nearly_touching", 1, [](const Point& x, double) { return x; }},
      {"four_lobes", 0.35,
       [=](const Point& x, double) {
         const double factor =
             1 + 0.2 * std::cos(4 * std::atan2(x.y(), x.x())) * std::exp(-(x.z() + 4) * (x.z() + 4) / 50);
         return across(x, factor, factor);
       }},
      {"flank_pushed_in", 0.35, [=](const Point& x, double) { return dented(x, 9); }},
      {"skirt_turned_in", 0.35,
       [=](const Point& x, double s) {
         const double t = s > 17.5 ? (s - 17.5) / 3.5 : 0;
         Point turned = across(x, 1 - 0.3 * t * t, 1 - 0.3 * t * t);
         turned.z() += 2 * t * t;
         return turned;
       }},
      {"collapsed", 0.35,
       [=](const Point& x, double) {
         Point p = dented(x, 12);
         p.z() -= 5 * std::exp(-(p.x() * p.x() + p.y() * p.y()) / 30); // the crown sinks
         return across(p, 0.8, 1.1);
       }},
  };
}

inline Result<parachute::CanopySurface> t10_surface(const T10FluidSize& size, const T10Shape& shape) {
  auto surface = t10_surface(size, shape.fullness);
  if (!surface) return surface;
  for (std::size_t i = 0; i < surface->points.size(); ++i)
    surface->points[i] =
        shape.move(surface->points[i], std::hypot(surface->material[i][0], surface->material[i][1]));
  return surface;
}

} // namespace drogue::test
