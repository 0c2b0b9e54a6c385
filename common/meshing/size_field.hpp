// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "common/meshing/point_tree.hpp"

namespace drogue::meshing {

/// A cylinder along z in which elements stay small.
struct Wake {
  Point bottom = Point::Zero(); ///< centre of the lower end
  double radius = 0;
  double length = 0;
  double size = 0;
};

/// Element sizes: `surface_size` at the surface, growing by `growth` per distance from it up to
/// `largest_size`, and the same around the wake.
struct SizeRule {
  double surface_size = 0;
  double largest_size = 0;
  double growth = 0;
  std::optional<Wake> wake;
};

class SizeField {
 public:
  SizeField(const SizeRule& rule, const std::vector<Point>& points, const std::vector<Triangle>& surface);
  [[nodiscard]] double operator()(const Point& x) const;

 private:
  SizeRule rule_;
  PointTree surface_; ///< nodes and centres of the triangles
};

} // namespace drogue::meshing
