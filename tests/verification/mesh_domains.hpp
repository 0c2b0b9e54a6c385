// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/mesh/mesh.hpp"

/// Domains for the verification of the mesh motion, meshed by Gmsh.
namespace drogue::test {

/// The square |x|, |y| <= 1 with a plate of no thickness from (-1/2, 0) to (1/2, 0), and one layer of
/// elements 0.01 high and 0.02 long on both of its sides [stein2003]. Groups: lines "plate" and "outer",
/// triangles "fluid", those of the two layers "layer".
[[nodiscard]] mesh::Mesh plate_in_square();

/// The box -3 <= x <= 5, |y|, |z| <= 3 around a sphere of diameter 1 at the origin. Groups: triangles
/// "sphere" and "outer", tetrahedra "fluid".
[[nodiscard]] mesh::Mesh sphere_in_box();

} // namespace drogue::test
