// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

namespace drogue::parachute {

/// The constructed shapes; see the config schema.
enum class Shape { flat, conical, hemispherical, cross };

/// An open row between two rings of cloth, in units of the seam's s.
struct Gap {
  double from = 0;
  double to = 0;
};

/// A point of the cloth. s: length along a gore from the apex; theta: angle about the axis. On a cross the
/// polar coordinates of the flat pattern.
struct ClothNode {
  double s = 0;
  double theta = 0;
};

/// The constructed (cut) shape of a canopy. Round canopies: the main part from the vent edge s_vent to the
/// seam s_seam, and where skirt_ratio > 0 an inverted ring folded under it, to the skirt edge s_skirt. The
/// gore boundaries (radials) stand at theta = 2 pi (g + 1/2) / gores.
struct Canopy {
  double diameter = 0; ///< constructed diameter Dc [length]
  double vent_ratio = 0;
  double skirt_ratio = 0;
  int gores = 0;
  Shape shape = Shape::flat;
  double cone_angle = 0; ///< between side and base [rad]
  std::vector<Gap> gaps = {};
  double arm_width_ratio = 0; ///< cross
  int lines_per_arm = 0;      ///< cross

  [[nodiscard]] double s_vent() const;
  [[nodiscard]] double s_seam() const;
  [[nodiscard]] double s_skirt() const { return s_seam() + skirt_ratio * diameter; }
  /// Distance from the axis, and height over the apex (negative below it).
  [[nodiscard]] double radius(double s) const;
  [[nodiscard]] double height(double s) const;
  /// Area of the cloth, without vent and gaps.
  [[nodiscard]] double cloth_area() const;
};

/// Position in the constructed shape, the apex at the origin (flat canopies: z = 0, a skirt folded under the
/// disk).
[[nodiscard]] std::array<double, 3> constructed_position(const Canopy& canopy, const ClothNode& node);
/// Position in the unfolded pattern, unique on the cloth: (s cos theta, s sin theta, 0).
[[nodiscard]] std::array<double, 3> material_position(const ClothNode& node);

} // namespace drogue::parachute
