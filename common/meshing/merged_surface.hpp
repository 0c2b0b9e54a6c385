// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "common/base/result.hpp"
#include "common/meshing/tet_mesh.hpp"

namespace drogue::meshing {

/// The boundary of a volume that is cut open along membranes, with the two sides of each membrane put
/// together again: what a mesher can fill. Node numbers are those of the merged points unless said otherwise.
struct MergedSurface {
  std::vector<Point> points;
  /// Closed surfaces, normals out of the volume. The first one is the outer one.
  std::vector<std::vector<Triangle>> shells;
  /// Membranes inside the volume, a triangle where two faces were; none hangs together with another one.
  std::vector<std::vector<Triangle>> sheets;
  /// All faces that were there, in the original nodes, and the merged point of each original node that is on
  /// a face
  /// (-1: it is on none).
  std::vector<Triangle> faces;
  std::vector<std::int32_t> merged;
};

/// Takes the boundaries' triangles of `m` together; nodes at one place become one. Errors
/// (ErrorKind::numerical): three faces, or two with the same normal, at one place; a surface that is not
/// closed; not exactly one outer surface.
[[nodiscard]] Result<MergedSurface> merge_sides(const TetMesh& m);

/// Cuts a filled volume open again: corners of its tets that lie on merged points get the original node of
/// the faces that they reach without crossing a membrane. `tets` in, nodes below surface.points.size() being
/// the merged points; out, the original nodes there. Errors (ErrorKind::numerical): a face that is no tet's;
/// a corner that reaches no face, or faces of different nodes.
[[nodiscard]] Result<void> restore_sides(const MergedSurface& surface, std::vector<Tet>& tets);

} // namespace drogue::meshing
