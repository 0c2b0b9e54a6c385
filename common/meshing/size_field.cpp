// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/size_field.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace drogue::meshing {
namespace {

std::vector<Point> with_centres(std::vector<Point> points, const std::vector<Triangle>& surface) {
  points.reserve(points.size() + surface.size());
  for (const Triangle& t : surface) {
    Point sum = Point::Zero();
    for (const std::int32_t node : t) sum += points[static_cast<std::size_t>(node)];
    points.push_back(sum / 3);
  }
  return points;
}

double distance_to(const Wake& wake, const Point& x) {
  const double radial =
      std::max(0.0, std::hypot(x.x() - wake.bottom.x(), x.y() - wake.bottom.y()) - wake.radius);
  const double z = x.z() - wake.bottom.z();
  return std::hypot(radial, std::max({0.0, -z, z - wake.length}));
}

} // namespace

SizeField::SizeField(const SizeRule& rule, const std::vector<Point>& points,
                     const std::vector<Triangle>& surface)
    : rule_(rule), surface_(with_centres(points, surface)) {}

double SizeField::operator()(const Point& x) const {
  // The nearest sample of the surface is up to a third of an element from its nearest point.
  const double sampling = 0.3 * rule_.surface_size;
  const double cutoff = sampling + (rule_.largest_size - rule_.surface_size) / rule_.growth;
  const double distance = std::max(0.0, surface_.distance(x, cutoff, 0.02) - sampling);
  double size = std::min(rule_.largest_size, rule_.surface_size + rule_.growth * distance);
  if (rule_.wake) size = std::min(size, rule_.wake->size + rule_.growth * distance_to(*rule_.wake, x));
  return size;
}

} // namespace drogue::meshing
