// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coupler/projection/field_projection.hpp"
#include "coupler/projection/load_transfer.hpp"

namespace drogue::projection {

/// The pair of surfaces, ready for the coupling loop.
struct Interface {
  Surface structure; ///< completed
  Surface fluid;     ///< completed
  FieldProjection field;
  LoadTransfer load;
  MatchReport report;
};

/// Completes and checks both surfaces, integrates the products of their shape functions, and factors both
/// mass matrices. Errors (ErrorKind::config): see complete(), InterfaceQuadrature::create(), FieldProjection,
/// LoadTransfer.
[[nodiscard]] Result<Interface> make_interface(Surface structure, Surface fluid, const Settings& settings);

/// A field {structure nodes, 3} and its projection {fluid nodes, 3}.
struct ProjectedField {
  std::span<const double> structure, fluid;
};
inline constexpr std::size_t most_fields_at_once = 2;

/// What projected fields miss of their source, over the fluid's reference area in
/// InterfaceQuadrature::samples():
///   sqrt( int |d_f - d_s(pi)|^2 dA / int |d_s(pi)|^2 dA ),    0 when matching or where d_s is zero.
/// The least squares make it as small as the fluid's elements allow.
/// @pre not more than most_fields_at_once; as many defects as fields
void projection_defects(const Interface& interface, std::span<const ProjectedField> fields,
                        std::span<double> defects) noexcept;
/// Of one.
[[nodiscard]] inline double projection_defect(const Interface& interface, std::span<const double> structure,
                                              std::span<const double> fluid) noexcept {
  const ProjectedField field{structure, fluid};
  double defect = 0;
  projection_defects(interface, {&field, 1}, {&defect, 1});
  return defect;
}

} // namespace drogue::projection
