// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "coupler/launcher/peer.hpp"
#include "participant/cpp/participant.hpp"

namespace drogue::coupler {

/// A field as the coupler understands it.
struct ExpectedField {
  std::string_view name;
  v1::FieldContract::Quantity quantity;
  v1::FieldContract::Location location;
  std::uint32_t components;
  v1::FieldContract::TimeLevel time_level;
};

[[nodiscard]] const v1::FieldContract* find_input(const v1::Hello& hello, std::string_view name);
[[nodiscard]] const v1::FieldContract* find_output(const v1::Hello& hello, std::string_view name);

/// Checks a participant's contract: it must give every field of `outputs`; every input it needs must be one
/// of `inputs` (or optional). Quantity, location, components and time level must be the same. Errors:
/// ErrorKind::config.
[[nodiscard]] Result<void> check_contract(const launcher::Peer& peer,
                                          const std::vector<ExpectedField>& outputs,
                                          const std::vector<ExpectedField>& inputs);

/// The shape that the contract promises.
[[nodiscard]] Result<void> check_shape(const std::string& who, const v1::FieldContract& contract,
                                       const participant::FloatArray& array,
                                       const participant::InterfaceMesh& mesh);

/// Fluid and mesh mover must hold the same mesh and name the same interface nodes. A participant that gives
/// no hash is believed on its node count, with a warning.
[[nodiscard]] Result<void> check_same_mesh(const participant::InterfaceMesh& fluid,
                                           const participant::InterfaceMesh& mesh_mover);

} // namespace drogue::coupler
