// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/canopy.hpp"

#include <cmath>
#include <numbers>

namespace drogue::parachute {
namespace {

constexpr double pi = std::numbers::pi;

/// Area of the main part from the apex to s.
double cap_area(const Canopy& canopy, double s) {
  switch (canopy.shape) {
  case Shape::flat:
    return pi * s * s;
  case Shape::conical:
    return pi * s * s * std::cos(canopy.cone_angle);
  case Shape::hemispherical:
    return 2 * pi * 0.25 * canopy.diameter * canopy.diameter * (1 - std::cos(2 * s / canopy.diameter));
  case Shape::cross:
    break;
  }
  return 0;
}

} // namespace

double Canopy::s_vent() const {
  const double r = 0.5 * vent_ratio * diameter;
  switch (shape) {
  case Shape::flat:
    return r;
  case Shape::conical:
    return r / std::cos(cone_angle);
  case Shape::hemispherical:
    return 0.5 * diameter * std::asin(vent_ratio);
  case Shape::cross:
    break;
  }
  return 0;
}

double Canopy::s_seam() const {
  const double r = 0.5 * diameter;
  switch (shape) {
  case Shape::flat:
  case Shape::cross:
    return r;
  case Shape::conical:
    return r / std::cos(cone_angle);
  case Shape::hemispherical:
    return 0.5 * pi * r;
  }
  return r;
}

double Canopy::radius(double s) const {
  switch (shape) {
  case Shape::flat:
    return s <= s_seam() ? s : diameter - s;
  case Shape::conical:
    return s * std::cos(cone_angle);
  case Shape::hemispherical:
    return 0.5 * diameter * std::sin(2 * s / diameter);
  case Shape::cross:
    break;
  }
  return s;
}

double Canopy::height(double s) const {
  switch (shape) {
  case Shape::conical:
    return -s * std::sin(cone_angle);
  case Shape::hemispherical:
    return -0.5 * diameter * (1 - std::cos(2 * s / diameter));
  case Shape::flat:
  case Shape::cross:
    break;
  }
  return 0;
}

double Canopy::cloth_area() const {
  if (shape == Shape::cross) return diameter * diameter * arm_width_ratio * (2 - arm_width_ratio);
  double area = cap_area(*this, s_seam()) - cap_area(*this, s_vent());
  for (const Gap& gap : gaps)
    area -= cap_area(*this, gap.to * s_seam()) - cap_area(*this, gap.from * s_seam());
  if (skirt_ratio == 0) return area;
  const double r = radius(s_skirt());
  return area + pi * (0.25 * diameter * diameter - r * r);
}

std::array<double, 3> constructed_position(const Canopy& canopy, const ClothNode& node) {
  const double r = canopy.radius(node.s);
  return {r * std::cos(node.theta), r * std::sin(node.theta), canopy.height(node.s)};
}

std::array<double, 3> material_position(const ClothNode& node) {
  return {node.s * std::cos(node.theta), node.s * std::sin(node.theta), 0};
}

} // namespace drogue::parachute
