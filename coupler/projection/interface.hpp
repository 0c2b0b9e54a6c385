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

/// What a projected field misses of its source, over the fluid's reference area in
/// InterfaceQuadrature::samples():
///   sqrt( int |d_f - d_s(pi)|^2 dA / int |d_s(pi)|^2 dA ),    0 when matching or where d_s is zero.
/// The least squares make it as small as the fluid's elements allow.
/// @param structure {structure nodes, 3}  @param fluid {fluid nodes, 3}: its projection
[[nodiscard]] double projection_defect(const Interface& interface, std::span<const double> structure,
                                       std::span<const double> fluid) noexcept;

} // namespace drogue::projection
