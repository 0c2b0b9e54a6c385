// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "common/mesh/mesh.hpp"
#include "coupler/projection/surface.hpp"

namespace drogue::coupler {

/// A surface of a mesh, its nodes numbered anew.
struct SurfaceFile {
  mesh::Mesh mesh;
  std::string group;
  std::vector<std::int32_t> nodes; ///< {surface nodes}: nodes of the mesh
  projection::Surface surface;     ///< completed; with the mesh's "material" coordinates if it has them
};

/// Reads the surface elements of one group; of the only group of surfaces when `group` is empty.
/// Errors (ErrorKind::config): the mesh cannot be read, no such group, a group without surface elements, an
/// element without area.
[[nodiscard]] Result<SurfaceFile> read_surface(const std::filesystem::path& file, const std::string& group);

} // namespace drogue::coupler
