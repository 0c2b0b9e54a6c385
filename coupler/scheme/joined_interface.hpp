// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "participant/cpp/participant.hpp"

namespace drogue::coupler {

/// The interfaces of several structures as one: nodes and elements one after the other. What only some of
/// them give is filled up with what it stands for where it is not given: reference by points, material by
/// reference, velocity by zero. They lose their places in meshes of their own.
[[nodiscard]] participant::InterfaceMesh joined(std::span<const participant::InterfaceMesh> meshes);

/// Rows `first` to `first + count` of an array.
[[nodiscard]] participant::FloatArray rows_of(const participant::FloatArray& array, std::size_t first,
                                              std::size_t count);
/// Puts the rows of `more` behind those of `array`.
void append_rows(participant::FloatArray& array, const participant::FloatArray& more);

} // namespace drogue::coupler
