// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "drogue/v1/wire.pb.h"
#include "participant/cpp/participant.hpp"

namespace drogue::coupler::conform {

/// How large the inputs are that the participant is given.
struct Sizes {
  double time_step = 0.01;    ///< [time]
  double displacement = 1e-4; ///< of a step, relative to the size of the interface
  double load = 1e-3;         ///< pressure or traction [stress]
};

/// What the shapes and the scale of the inputs depend on.
struct Surface {
  std::uint64_t nodes = 0, mesh_nodes = 0;
  double size = 1; ///< diagonal of the box around the interface [length]
};

/// Number of rows of a field on this surface.
[[nodiscard]] std::uint64_t rows(const v1::FieldContract& field, const Surface& surface);

/// Inputs of an iteration (from 1) of a step (from 1): a motion that moves everything alike, with the
/// velocity that goes with it, and a load that varies from node to node. They grow with step and iteration.
[[nodiscard]] participant::Fields inputs_for(const v1::Hello& hello, const Surface& surface,
                                             const Sizes& sizes, int step, int iteration);

} // namespace drogue::coupler::conform
