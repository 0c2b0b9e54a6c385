// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/supports.hpp"

#include <cmath>

namespace drogue::structure {
namespace {

/// @pre motion.equation is set
void differentiate(const config::Expression& d, const double* X, double t, double h, HeldMotion& motion) {
  const auto value = [&](double at) { return d(X[0], X[1], X[2], at); };
  const double before2 = value(t - 2 * h), before = value(t - h), after = value(t + h),
               after2 = value(t + 2 * h);
  const double v = (8 * (after - before) - (after2 - before2)) / (12 * h);
  const double a =
      (16 * ((after - motion.u) + (before - motion.u)) - ((after2 - motion.u) + (before2 - motion.u))) /
      (12 * h * h);
  if (!std::isfinite(v) || !std::isfinite(a)) return;
  motion.v = v;
  motion.a = a;
}

} // namespace

Result<std::vector<HeldMotion>> held_motion(const Model& model, double t, double h) {
  std::vector<HeldMotion> motions;
  for (const SupportSet& support : model.supports)
    for (const std::int32_t node : support.nodes)
      for (std::size_t c = 0; c < 3; ++c) {
        if (!support.held[c]) continue;
        HeldMotion motion{.equation = 3 * static_cast<std::size_t>(node) + c};
        const config::Expression& d = support.displacement[c];
        if (!d.is_zero()) {
          const double* X = &model.mesh.points[3 * static_cast<std::size_t>(node)];
          motion.u = d(X[0], X[1], X[2], t);
          if (!std::isfinite(motion.u))
            return numerical_error(
                "the displacement of the support of group \"{}\", \"{}\", is {} at x = {}, y = {}, "
                "z = {}, t = {}",
                support.group, d.text(), motion.u, X[0], X[1], X[2], t);
          differentiate(d, X, t, h, motion);
        }
        motions.push_back(motion);
      }
  return motions;
}

} // namespace drogue::structure
