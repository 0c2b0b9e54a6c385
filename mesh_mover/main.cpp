// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/meshing/remesh.hpp"
#include "common/program/solver_program.hpp"
#include "mesh_mover/program.hpp"

int main(int argc, char** argv) {
  using namespace drogue;
  return run_solver_program({.name = "mesh_mover",
                             .description =
                                 "Moves a fluid mesh with its boundaries: an elastic pseudo-solid on "
                                 "tetrahedra or triangles",
                             .check = mesh_mover::check,
                             .run = mesh_mover::run,
                             .remesh = meshing::remesh_file},
                            argc, argv);
}
