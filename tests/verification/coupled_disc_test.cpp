// SPDX-License-Identifier: GPL-3.0-or-later
// A membrane disc clamped at its rim, with fluid on both sides, in uniform flow at Re = U 2R / nu = 100: a
// canopy in the small. The answers with a structure whose mesh is the fluid's surface, and with one that has
// triangles of its own, must agree. Units: R = U = rho = 1.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "common/mesh/msh.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/coupled_run.hpp"
#include "tests/verification/disc_mesh.hpp"
#include "tests/verification/fluid_meshes.hpp"

namespace drogue::test {
namespace {

constexpr double dt = 0.2, mean_from = 8, end = 12;

struct Disc {
  int fluid_rings = 5;
  int structure_rings = 5;
};

/// Adds to `from` the points up to `to`, the first `step` apart and each `growth` times farther than the
/// last.
std::vector<double> grown(double from, double to, double step, double growth) {
  const int n = static_cast<int>(
      std::lround(std::log(1 + std::abs(to - from) * (growth - 1) / step) / std::log(growth)));
  const double whole = std::pow(growth, n) - 1;
  std::vector<double> x;
  for (int k = 1; k <= n; ++k) x.push_back(from + (to - from) * (std::pow(growth, k) - 1) / whole);
  return x;
}

std::vector<double> uniform_radii(int rings) {
  std::vector<double> radii;
  for (int k = 1; k <= rings; ++k) radii.push_back(static_cast<double>(k) / rings);
  return radii;
}

/// A cylinder r < 4, -3 < z < 6 about the disc r < 1, z = 0, whose inner nodes are there twice: groups
/// `lower` and `upper`, joined at the rim.
mesh::Mesh fluid_mesh(int rings) {
  std::vector<double> radii = uniform_radii(rings);
  for (const double r : grown(1, 4, 1.2 / rings, 1.35)) radii.push_back(r);
  const mesh::Mesh plane = disc_mesh(radii, rings);
  std::vector<double> z = grown(0, -3, 1.0 / rings, 1.35), above = grown(0, 6, 1.0 / rings, 1.3);
  std::reverse(z.begin(), z.end());
  const std::int32_t base = plane.node_count() * static_cast<std::int32_t>(z.size());
  z.push_back(0);
  z.insert(z.end(), above.begin(), above.end());
  mesh::Mesh m = fluid::test::extruded(plane, z);

  const std::int32_t on_disc = 1 + 3 * rings * (rings + 1), inner = on_disc - 6 * rings;
  const std::int32_t first = m.node_count();
  for (std::int32_t i = 0; i < inner; ++i) {
    const auto at = 3 * static_cast<std::size_t>(base + i);
    m.points.insert(m.points.end(), {m.points[at], m.points[at + 1], m.points[at + 2]});
  }
  const auto upper = [&](std::int32_t node) {
    return node >= base && node < base + inner ? first + node - base : node;
  };
  for (mesh::ElementBlock& block : m.blocks) {
    if (block.kind != mesh::ElementKind::tet4) continue;
    for (std::size_t e = 0; e < block.nodes.size(); e += 4) {
      const auto nodes = std::span(block.nodes).subspan(e, 4);
      if (*std::max_element(nodes.begin(), nodes.end()) < base + plane.node_count())
        continue; // below the disc
      for (std::int32_t& node : nodes) node = upper(node);
    }
  }
  mesh::ElementBlock low{"lower", mesh::ElementKind::tri3, {}}, high{"upper", mesh::ElementKind::tri3, {}};
  const mesh::ElementBlock& triangles = *plane.blocks_of("fluid")[0];
  for (std::int32_t e = 0; e < triangles.count(); ++e) {
    const auto t = triangles.element(e);
    if (std::max({t[0], t[1], t[2]}) >= on_disc) continue;
    for (const std::int32_t node : t) {
      low.nodes.push_back(base + node);
      high.nodes.push_back(upper(base + node));
    }
  }
  m.blocks.push_back(low);
  m.blocks.push_back(high);
  return m;
}

mesh::Mesh structure_mesh(int rings) {
  mesh::Mesh m = disc_mesh(uniform_radii(rings), rings);
  m.blocks[0].group = "disc";
  m.blocks[1] = {"rim", mesh::ElementKind::point1, m.nodes_of("wall")};
  return m;
}

void write_case(const std::filesystem::path& folder, const Disc& c) {
  ASSERT_TRUE(mesh::write_msh(folder / "fluid.msh", fluid_mesh(c.fluid_rings)).ok());
  ASSERT_TRUE(mesh::write_msh(folder / "structure.msh", structure_mesh(c.structure_rings)).ok());
  std::ofstream(folder / "structure.textproto") << fmt::format(
      "mesh: 'structure.msh' interface: 'disc'\n"
      "membrane {{ group: 'disc' thickness: 0.001 density: 50 youngs_modulus: 5000 prestress: 200 }}\n"
      "support {{ group: 'rim' }}\n"
      "time {{ step: {} }} newton {{ displacement_tolerance: 1e-8 }}\n"
      "output {{ field_interval: 0 }}\n",
      dt);
  std::ofstream(folder / "fluid.textproto")
      << fmt::format("mesh: 'fluid.msh' density: 1 dynamic_viscosity: 0.02\n"
                     "initial_velocity {{ z: '1' }} initial_flow: PROJECTED\n"
                     "phase {{ formulation: DSD_SST step: {} }}\n"
                     "boundary {{ name: 'z0' velocity {{ z: '1' }} }}\n"
                     "boundary {{ name: 'z1' traction_free {{}} }}\n"
                     "boundary {{ name: 'wall' free_slip {{}} }}\n"
                     "boundary {{ name: 'lower' no_slip {{}} }}\n"
                     "boundary {{ name: 'upper' no_slip {{}} }}\n"
                     "interface: 'lower' interface: 'upper'\n"
                     "output {{ field_interval: 0 }}\n",
                     dt);
  std::ofstream(folder / "mesh.textproto") << "mesh: 'fluid.msh' increment: FROM_INITIAL\n"
                                              "boundary { name: 'lower' displacement {} }\n"
                                              "boundary { name: 'upper' displacement {} }\n"
                                              "boundary { name: 'z0' fixed {} }\n"
                                              "boundary { name: 'z1' fixed {} }\n"
                                              "boundary { name: 'wall' fixed {} }\n"
                                              "interface: 'lower' interface: 'upper'\n"
                                              "output { field_interval: 0 }\n";
  std::ofstream(folder / "case.textproto")
      << fmt::format("name: 'disc in uniform flow' run_directory: 'run'\n"
                     "structure {{ command: 'structure_solver' config: 'structure.textproto' }}\n"
                     "mesh_mover {{ command: 'mesh_mover' config: 'mesh.textproto' }}\n"
                     "fluid {{ command: 'fluid_solver' config: 'fluid.textproto' }}\n"
                     "time {{ step: {} steps: {} }}\n"
                     "loop {{ relative: 1e-3 }}\n"
                     "load_factor: 'min(1, t)'\n"
                     "outer_boundary: FIXED\n",
                     dt, std::lround(end / dt));
}

struct Answer {
  double deflection = 0; ///< mean of the surface and of the last third of the time
  double drag = 0;
};

Answer run(const std::string& name, const Disc& c) {
  const auto folder = fresh_folder(name);
  write_case(folder, c);
  const CoupledRun coupled = run_coupled(folder, std::chrono::minutes(60));
  const auto mean = [&](const std::string& quantity) {
    const std::vector<double> t = column(coupled.steps, "time"), values = column(coupled.steps, quantity);
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < t.size(); ++i) {
      if (t[i] < mean_from) continue;
      sum += values[i];
      ++count;
    }
    return sum / count;
  };
  const Answer answer{mean("mean_displacement_z"), mean("force_z")};
  fmt::print("{}: mean deflection {:.5f}, drag coefficient {:.5f}, {:.2f} iterations a step\n", name,
             answer.deflection, answer.drag / (0.5 * std::numbers::pi), coupled.mean_iterations());
  return answer;
}

TEST(Disc, AnswersAlikeOnMatchingAndOtherMeshes) {
  const Answer matching = run("matching", {});
  EXPECT_GT(matching.deflection, 0.05); // a canopy, not a plate
  for (const int rings : {4, 7}) {
    const Answer other = run(fmt::format("structure_rings_{}", rings), {.structure_rings = rings});
    const std::string id = fmt::format("coupler/disc_structure_rings_{}_fluid_5", rings);
    verify_relative(id, "mean_deflection", other.deflection, matching.deflection, 0.02);
    verify_relative(id, "drag", other.drag, matching.drag, 0.02);
  }
}

} // namespace
} // namespace drogue::test
