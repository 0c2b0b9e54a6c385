// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/verification/flexible_cavity.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include <fmt/format.h>

#include "common/mesh/msh.hpp"

namespace drogue::test {
namespace {

/// n x n squares in two triangles each; the diagonals leave every corner, so that no triangle has walls
/// alone.
mesh::Mesh square(int n) {
  mesh::Mesh m;
  const auto id = [n](int i, int j) { return j * (n + 1) + i; };
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      m.points.insert(m.points.end(), {static_cast<double>(i) / n, static_cast<double>(j) / n, 0.0});
  mesh::ElementBlock fluid{"fluid", mesh::ElementKind::tri3, {}};
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = id(i, j), b = id(i + 1, j), c = id(i + 1, j + 1), d = id(i, j + 1);
      if ((2 * i < n) == (2 * j < n))
        fluid.nodes.insert(fluid.nodes.end(), {a, b, c, a, c, d});
      else
        fluid.nodes.insert(fluid.nodes.end(), {a, b, d, b, c, d});
    }
  const auto line = [](const char* group) { return mesh::ElementBlock{group, mesh::ElementKind::line2, {}}; };
  auto bottom = line("bottom"), lid = line("lid"), walls = line("walls"), inflow = line("inflow"),
       outflow = line("outflow");
  for (int i = 0; i < n; ++i) {
    bottom.nodes.insert(bottom.nodes.end(), {id(i, 0), id(i + 1, 0)});
    lid.nodes.insert(lid.nodes.end(), {id(i + 1, n), id(i, n)});
    const bool open = 8 * i >= 7 * n;
    auto& left = open ? inflow : walls;
    auto& right = open ? outflow : walls;
    left.nodes.insert(left.nodes.end(), {id(0, i + 1), id(0, i)});
    right.nodes.insert(right.nodes.end(), {id(n, i), id(n, i + 1)});
  }
  m.blocks = {fluid, bottom, lid, walls, inflow, outflow};
  return m;
}

mesh::Mesh membrane(int n) {
  mesh::Mesh m;
  mesh::ElementBlock lines{"membrane", mesh::ElementKind::line2, {}};
  for (int i = 0; i <= n; ++i) m.points.insert(m.points.end(), {static_cast<double>(i) / n, 0.0, 0.0});
  for (int i = 0; i < n; ++i) lines.nodes.insert(lines.nodes.end(), {i, i + 1});
  m.blocks = {lines, {"ends", mesh::ElementKind::point1, {0, n}}};
  return m;
}

} // namespace

void write_case(const std::filesystem::path& folder, const Cavity& c) {
  ASSERT_TRUE(mesh::write_msh(folder / "fluid.msh", square(c.cells)).ok());
  ASSERT_TRUE(mesh::write_msh(folder / "structure.msh", membrane(c.cells)).ok());
  std::ofstream(folder / "structure.textproto") << fmt::format(
      "mesh: 'structure.msh' plane: true interface: 'membrane'\n"
      "truss {{ group: 'membrane' area: 0.002 density: 500 youngs_modulus: 250 strain: GREEN }}\n"
      "support {{ group: 'ends' components: 'xy' }}\n"
      "time {{ step: {} rho_infinity: 0.9 }}\n"
      "newton {{ displacement_tolerance: 1e-10 }}\n"
      "probe {{ name: 'middle' x: 0.5 y: 0 z: 0 }}\n"
      "output {{ field_interval: 0 }}\n",
      c.time_step);
  // p = 0 where the flow leaves: no velocity along the opening, so that no viscous stress acts across it.
  std::ofstream(folder / "fluid.textproto")
      << fmt::format("mesh: 'fluid.msh' density: 1 dynamic_viscosity: 0.01\n"
                     "phase {{ formulation: DSD_SST step: {} }}\n"
                     "stabilisation {{ time_weight: false }}\n"
                     "newton {{ residual_tolerance: 1e-9 }}\n"
                     "boundary {{ name: 'lid' velocity {{ x: '1-cos(2*pi*t/5)' }} }}\n"
                     "boundary {{ name: 'inflow' velocity {{ x: '(1-cos(2*pi*t/5))*(8*y-7)' }} }}\n"
                     "boundary {{ name: 'outflow' no_slip {{ components: 'y' }} }}\n"
                     "boundary {{ name: 'walls' no_slip {{}} }}\n"
                     "boundary {{ name: 'bottom' no_slip {{}} }}\n"
                     "interface: 'bottom' interface_load: CONSISTENT_TRACTION\n"
                     "output {{ field_interval: 0 }}\n",
                     c.time_step);
  std::ofstream(folder / "mesh.textproto") << "mesh: 'fluid.msh' tolerance: 1e-8 increment: FROM_INITIAL\n"
                                              "boundary { name: 'bottom' displacement {} }\n"
                                              "boundary { name: 'lid' fixed {} }\n"
                                              "boundary { name: 'inflow' fixed {} }\n"
                                              "boundary { name: 'outflow' fixed {} }\n"
                                              "boundary { name: 'walls' fixed {} }\n"
                                              "interface: 'bottom'\n"
                                              "output { field_interval: 0 }\n";
  std::ofstream(folder / "case.textproto")
      << fmt::format("name: 'cavity with a flexible bottom' run_directory: 'run'\n"
                     "structure {{ {} }}\n"
                     "mesh_mover {{ command: 'mesh_mover' config: 'mesh.textproto' }}\n"
                     "fluid {{ command: 'fluid_solver' config: 'fluid.textproto' }}\n"
                     "time {{ step: {} steps: {} }}\n"
                     "loop {{ relative: 1e-6 max_iterations: 60 }}\n"
                     "acceleration {{ {} }}\n"
                     "outer_boundary: FIXED\n",
                     c.structure, c.time_step, std::lround(c.end / c.time_step), c.acceleration);
}

} // namespace drogue::test
