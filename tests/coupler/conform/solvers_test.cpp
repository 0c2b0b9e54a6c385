// SPDX-License-Identifier: GPL-3.0-or-later
// Drogue's own solvers and the example keep every promise of the protocol: a box of fluid under a membrane.
#include "common/mesh/msh.hpp"
#include "tests/mesh_mover/box_mesh.hpp"
#include "tests/support/checkpoint_runs.hpp"

namespace drogue::test {
namespace {

namespace fs = std::filesystem;
constexpr int cells = 3;

/// The lid of the unit box, held at its rim.
mesh::Mesh membrane() {
  mesh::Mesh m;
  const int row = cells + 1;
  mesh::ElementBlock cloth{"cloth", mesh::ElementKind::tri3, {}}, rim{"rim", mesh::ElementKind::point1, {}};
  for (int j = 0; j < row; ++j)
    for (int i = 0; i < row; ++i) {
      m.points.insert(m.points.end(), {double(i) / cells, double(j) / cells, 1});
      const std::int32_t a = j * row + i;
      if (i == 0 || j == 0 || i == cells || j == cells) rim.nodes.push_back(a);
      if (i < cells && j < cells)
        cloth.nodes.insert(cloth.nodes.end(), {a, a + 1, a + 1 + row, a, a + 1 + row, a + row});
    }
  m.blocks = {cloth, rim};
  return m;
}

fs::path folder_of_a_case(const std::string& name) {
  const auto folder = fresh_folder(name);
  const auto grid = uniform(0, 1, cells);
  EXPECT_TRUE(mesh::write_msh(folder / "fluid.msh",
                              box_mesh({grid, grid, grid}, [](int, int, int) { return false; })));
  EXPECT_TRUE(mesh::write_msh(folder / "structure.msh", membrane()));
  std::ofstream(folder / "structure.textproto")
      << "mesh: 'structure.msh' interface: 'cloth'\n"
         "membrane { group: 'cloth' thickness: 0.001 density: 100 youngs_modulus: 1e4 prestress: 1e3 }\n"
         "support { group: 'rim' }\n"
         "time { step: 0.01 }\n"
         "output { field_interval: 1 }\n";
  std::ofstream fluid(folder / "fluid.textproto"), mover(folder / "mesh.textproto");
  fluid << "mesh: 'fluid.msh' density: 1 dynamic_viscosity: 0.01\n"
           "phase { formulation: DSD_SST step: 0.01 }\n"
           "boundary { name: 'z1' no_slip {} }\n"
           "interface: 'z1'\n"
           "output { field_interval: 1 }\n";
  mover << "mesh: 'fluid.msh'\n"
           "boundary { name: 'z1' displacement {} }\n"
           "interface: 'z1'\n"
           "output { field_interval: 1 }\n";
  for (const char* side : {"x0", "x1", "y0", "y1", "z0"}) {
    fluid << "boundary { name: '" << side << "' traction_free {} }\n";
    mover << "boundary { name: '" << side << "' translated {} }\n";
  }
  return folder;
}

void expect_conform(const fs::path& folder, std::vector<std::string> command) {
  command.insert(command.begin(), {"conform", "--"});
  EXPECT_EQ(run_coupler_with(folder, command), 0) << read_text(folder / "output.txt");
}

TEST(ConformSolvers, StructureSolver) {
  expect_conform(folder_of_a_case("structure"), {"structure_solver", "run", "structure.textproto"});
}

TEST(ConformSolvers, FluidSolver) {
  expect_conform(folder_of_a_case("fluid"), {"fluid_solver", "run", "fluid.textproto"});
}

TEST(ConformSolvers, MeshMover) {
  expect_conform(folder_of_a_case("mesh_mover"), {"mesh_mover", "run", "mesh.textproto"});
}

TEST(ConformSolvers, MeshMoverOnTwoRanks) {
  const fs::path folder = folder_of_a_case("mesh_mover_ranks");
  std::ofstream(folder / "mesh.textproto", std::ios::app)
      << "linear_solver: ITERATIVE\n"; // direct factors are not shared
  expect_conform(folder, {"mpiexec", "--oversubscribe", "--bind-to", "none", "-n", "2",
                          DROGUE_BIN_DIR "/mesh_mover", "run", "mesh.textproto"});
}

TEST(ConformSolvers, ExampleMeshMoverInPython) {
  expect_conform(folder_of_a_case("python"),
                 {DROGUE_PYTHON, DROGUE_SOURCE_DIR "/examples/python_mesh_mover/mesh_mover.py", "--mesh",
                  "fluid.msh", "--interface", "z1"});
}

} // namespace
} // namespace drogue::test
