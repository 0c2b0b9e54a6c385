// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/parachute_mesher/inflated_shape.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace drogue::parachute {
namespace {

constexpr double pi = std::numbers::pi;

/// An ellipse r = a sin(phi), z = b cos(phi), phi as a function of its arc length from the apex.
class Meridian {
 public:
  Meridian(double a, double b) : a_(a), b_(b) {
    double length = 0;
    for (int i = 0; i < steps; ++i) {
      lengths_.push_back(length);
      const double phi = (i + 0.5) * dphi;
      length += dphi * std::hypot(a_ * std::cos(phi), b_ * std::sin(phi));
    }
    lengths_.push_back(length);
  }
  [[nodiscard]] double phi(double s) const {
    const auto after = std::lower_bound(lengths_.begin() + 1, lengths_.end() - 1, s);
    const auto i = static_cast<double>(after - lengths_.begin());
    return dphi * (i - (*after - s) / (*after - *(after - 1)));
  }
  [[nodiscard]] double equator() const { return lengths_[steps / 2]; }
  [[nodiscard]] double a() const { return a_; }
  [[nodiscard]] double b() const { return b_; }

 private:
  static constexpr int steps = 4000;
  static constexpr double dphi = pi / steps;
  double a_, b_;
  std::vector<double> lengths_;
};

/// The height that puts the seam on the equator.
Meridian meridian(const Canopy& canopy) {
  const double a = 0.335 * canopy.diameter;
  double low = 0.3 * a, high = 1.5 * a;
  for (int i = 0; i < 60; ++i) {
    const double b = 0.5 * (low + high);
    (Meridian(a, b).equator() > canopy.s_seam() ? high : low) = b;
  }
  return {a, 0.5 * (low + high)};
}

/// Half the opening angle of the arc whose length is `ratio` times its chord.
double half_angle(double ratio) {
  double low = 0, high = 0.9 * pi;
  for (int i = 0; i < 60; ++i) {
    const double phi = 0.5 * (low + high);
    (phi > ratio * std::sin(phi) ? high : low) = phi;
  }
  return 0.5 * (low + high);
}

std::array<double, 3> inflated_position(const Canopy& canopy, const Meridian& curve, double s, double theta,
                                        double fullness) {
  const double phi = curve.phi(s), alpha = pi / canopy.gores;
  const double r = curve.a() * std::sin(phi), z = curve.b() * std::cos(phi);
  const double dr = curve.a() * std::cos(phi), dz = -curve.b() * std::sin(phi), norm = std::hypot(dr, dz);
  // Gores start at theta = alpha (Canopy); t runs from -1 to 1 across one.
  const double gore = std::floor((theta - alpha) / (2 * alpha));
  const double t = (theta - alpha) / alpha - 2 * gore - 1;
  const double half_chord = r * std::sin(alpha);
  const double ratio = 1 + fullness * std::max(canopy.radius(s) * alpha / half_chord - 1, 1e-9);
  const double half = half_angle(ratio), radius = half_chord / std::sin(half);
  const double across = radius * std::sin(half * t);
  const double bulge = radius * (std::cos(half * t) - std::cos(half));
  const double R = r * std::cos(alpha) - bulge * dz / norm, Z = z + bulge * dr / norm;
  const double centre = 2 * alpha * (gore + 1);
  return {R * std::cos(centre) - across * std::sin(centre), R * std::sin(centre) + across * std::cos(centre),
          Z};
}

} // namespace

std::vector<double> inflated_displacement(const Canopy& canopy, const mesh::Mesh& structure,
                                          double fullness) {
  std::vector<double> displacement(structure.points.size(), 0);
  const Meridian curve = meridian(canopy);
  const std::vector<double>& material = structure.node_fields.at("material").values;
  for (const std::int32_t node : structure.nodes_of("canopy")) {
    const std::size_t i = 3 * static_cast<std::size_t>(node);
    const double s = std::hypot(material[i], material[i + 1]);
    const double theta = std::atan2(material[i + 1], material[i]);
    const auto x = inflated_position(canopy, curve, s, theta, fullness);
    for (std::size_t k = 0; k < 3; ++k) displacement[i + k] = x[k] - structure.points[i + k];
  }
  return displacement;
}

} // namespace drogue::parachute
