// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "common/base/result.hpp"
#include "common/mesh/mesh.hpp"

namespace drogue::mesh {

/// Reads a mesh: .msh of the versions 2 to 2.2 and 4.1 (by name or by content), text or binary, by ourselves
/// and with every number checked before it is used; whatever else Gmsh opens, by Gmsh, without fields. Every
/// element must belong to a named physical group of its dimension; nodes keep the order of their tags;
/// NodeData of a .msh become node fields.
///
/// Errors (ErrorKind::config): the file cannot be opened, is called .msh and is none or a damaged one (with
/// the line or the byte), holds no elements in named groups, an element kind that Drogue does not know, nodes
/// that no element uses, or elements and fields on nodes that are not there.
[[nodiscard]] Result<Mesh> read_msh(const std::filesystem::path& file);

/// Writes MSH 4.1 (binary) with physical groups for every group of the mesh and one NodeData section a node
/// field. Written to a temporary file and renamed, so that a failure leaves nothing half written.
[[nodiscard]] Result<void> write_msh(const std::filesystem::path& file, const Mesh& mesh);

} // namespace drogue::mesh
