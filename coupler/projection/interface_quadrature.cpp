// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/interface_quadrature.hpp"

#include "coupler/projection/pairing.hpp"

namespace drogue::projection {
namespace {

Error too_far(const MatchReport& r, const Surface& structure, const Surface& fluid,
              const Settings& settings) {
  return config_error("the {} surface and the {} surface do not lie on one another: {} of {} points of the "
                      "first ({:.2g} % of its area) "
                      "are further from the second than {:.3g} of its size; the largest gap is {:.3g} of the "
                      "size, at ({:.6g}, {:.6g}, "
                      "{:.6g}) in material coordinates. Check the units, positions and material coordinates "
                      "of the two meshes, or "
                      "raise projection.largest_gap",
                      fluid.name, structure.name, r.unmatched_points, r.points, 100 * r.unmatched_area,
                      settings.largest_gap, r.largest_gap, r.largest_gap_at[0], r.largest_gap_at[1],
                      r.largest_gap_at[2]);
}

Error too_oblique(const MatchReport& r, const Surface& structure, const Surface& fluid,
                  const Settings& settings) {
  return config_error(
      "the {} surface and the {} surface stand at {:.3g} degrees to one another at ({:.6g}, "
      "{:.6g}, {:.6g}) in material coordinates; {:.3g} are allowed. Refine the coarser mesh where "
      "it is bent, or raise projection.largest_normal_angle",
      fluid.name, structure.name, r.worst_normal_angle, r.worst_normal_at[0], r.worst_normal_at[1],
      r.worst_normal_at[2], settings.largest_normal_angle);
}

} // namespace

Result<InterfaceQuadrature> InterfaceQuadrature::create(const Surface& structure, const Surface& fluid,
                                                        const Settings& settings) {
  InterfaceQuadrature made = Pairing(structure, fluid, settings).make();
  const MatchReport& report = made.report_;
  if (report.unmatched_area > settings.largest_unmatched_area)
    return too_far(report, structure, fluid, settings);
  if (report.worst_normal_angle > settings.largest_normal_angle)
    return too_oblique(report, structure, fluid, settings);
  return made;
}

} // namespace drogue::projection
