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

/// Completes and checks both surfaces, locates the points, and factors both mass matrices.
/// Where the fluid's points are too few for the structure's elements, they are refined there, up to fourfold.
/// Errors (ErrorKind::config): see complete(), InterfaceQuadrature::create(), FieldProjection, LoadTransfer.
[[nodiscard]] Result<Interface> make_interface(Surface structure, Surface fluid, const Settings& settings);

} // namespace drogue::projection
