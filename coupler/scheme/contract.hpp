// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "participant/cpp/participant.hpp"

namespace drogue::coupler {

[[nodiscard]] const v1::FieldContract* find_input(const v1::Hello& hello, std::string_view name);
[[nodiscard]] const v1::FieldContract* find_output(const v1::Hello& hello, std::string_view name);

/// Checks a contract against what the coupler does with a "fluid", "structure" or "mesh_mover": it must give
/// the outputs that the coupling needs; every input it needs must be one that the coupler has. Quantity,
/// location, components and time level must be the same. The fluid's load is looked for in
/// Participants::choose_load. Errors: ErrorKind::config.
/// @param who the participant's name, for messages
[[nodiscard]] Result<void> check_role(const std::string& role, const std::string& who,
                                      const v1::Hello& hello);

/// Nodes of a participant.
struct MeshSize {
  std::uint64_t interface_nodes = 0, mesh_nodes = 0;
};
/// The shape that the contract promises.
[[nodiscard]] Result<void> check_shape(const std::string& who, const v1::FieldContract& contract,
                                       const participant::FloatArray& array, const MeshSize& size);

/// Fluid and mesh mover must hold the same mesh and name the same interface nodes. A participant that gives
/// no hash is believed on its node count, with a warning.
[[nodiscard]] Result<void> check_same_mesh(const participant::InterfaceMesh& fluid,
                                           const participant::InterfaceMesh& mesh_mover);

/// The interfaces of the two that hold the fluid's mesh.
struct MeshHolders {
  const participant::InterfaceMesh& fluid;
  const participant::InterfaceMesh& mesh_mover;
};
/// After a mesh was replaced: interface nodes that were one node of the mesh are one node again. Errors
/// (ErrorKind::peer): they are not.
[[nodiscard]] Result<void> check_same_pairs(const MeshHolders& before, const MeshHolders& after);

} // namespace drogue::coupler
