// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "common/config/expression.hpp"

namespace drogue::structure {

/// Factor on a natural length as a function of time: a table times an expression of t.
///
/// Between the points of the table (t_i, f_i) the factor is f_i + (f_{i+1} - f_i) r(s), s = (t -
/// t_i)/(t_{i+1} - t_i); before and after them it is constant. The smooth ramp r = s^3 (10 - 15 s + 6 s^2)
/// has no first and second derivative at its ends, so that pulling starts and stops without a jerk; the other
/// one is r = s.
struct LengthSchedule {
  struct Point {
    double time = 0;
    double factor = 1;
  };
  std::vector<Point> points; ///< increasing times; empty: 1
  bool smooth = true;
  config::Expression factor = *config::Expression::parse("1");

  [[nodiscard]] double operator()(double t) const { return table(t) * factor(0, 0, 0, t); }

 private:
  [[nodiscard]] double table(double t) const {
    if (points.empty()) return 1;
    if (t <= points.front().time) return points.front().factor;
    const auto next =
        std::find_if(points.begin(), points.end(), [t](const Point& point) { return t < point.time; });
    if (next == points.end()) return points.back().factor;
    const Point &a = *(next - 1), &b = *next;
    const double s = (t - a.time) / (b.time - a.time);
    return a.factor + (b.factor - a.factor) * (smooth ? s * s * s * (10 - s * (15 - 6 * s)) : s);
  }
};

} // namespace drogue::structure
