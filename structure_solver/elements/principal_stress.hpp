// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace drogue::structure {

/// Largest and smallest principal second Piola-Kirchhoff stress at a point.
struct PrincipalStress {
  double largest = 0;
  double smallest = 0;
};

} // namespace drogue::structure
