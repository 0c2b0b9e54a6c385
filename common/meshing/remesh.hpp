// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <span>

#include "common/base/result.hpp"
#include "common/mesh/mesh.hpp"

namespace drogue::meshing {

/// Names of nodal fields. Of the old mesh: element sizes [length]; above 0 at the nodes whose tets should go.
/// Of the new one: the old number of the node, none for a new one; sizes as well.
inline constexpr const char* size_field_name = "size";
inline constexpr const char* worn_field_name = "worn";
inline constexpr const char* previous_field_name = "previous";

/// The sizes with which a mesh as fine as this is made, at each node, on `points` {nodes, 3}: from the mean
/// volume of the tets (in the plane: area of the triangles) around it.
[[nodiscard]] mesh::NodeField sizes_of(const mesh::Mesh& mesh, std::span<const double> points);

/// Meshes the volume of a mesh of tets anew and keeps its boundary to the bit: every node of a boundary
/// triangle, and every boundary triangle, stays; the two sides of a membrane keep their nodes. With the field
/// "worn", only the tets at worn nodes are replaced, unless that fails. Nodes: those that stay in their old
/// order, then new ones. Blocks: the boundaries in their old order, then the volume. Fields on the nodes are
/// copied where nodes stay and interpolated elsewhere. Element sizes: the field "size", or where there is
/// none sizes_of the mesh. A mesh without tets is a plane one, with triangles for tets and lines for
/// triangles.
///
/// Every fresh process makes the same mesh of the same input, a second call in one process may give another
/// one.
///
/// Errors: ErrorKind::config when the mesh is none of tets in one group with boundaries of triangles (of
/// triangles in one group with boundaries of lines, none of them a cut);
/// ErrorKind::numerical when the surface cannot be filled, or the result fails a check (conformity, boundary,
/// volume): such a mesh is never returned.
[[nodiscard]] Result<mesh::Mesh> remesh(const mesh::Mesh& old);

/// remesh() from file to file.
[[nodiscard]] Result<void> remesh_file(const std::filesystem::path& from, const std::filesystem::path& to);

/// remesh() in a process of its own, so that the result depends on the input alone: `program` is started as
/// "PROGRAM remesh FROM TO", FROM being TO with ".before" added, which is removed when all went well. Errors:
/// as remesh().
[[nodiscard]] Result<mesh::Mesh> remesh_in_process(const std::filesystem::path& program,
                                                   const mesh::Mesh& old, const std::filesystem::path& to);

} // namespace drogue::meshing
