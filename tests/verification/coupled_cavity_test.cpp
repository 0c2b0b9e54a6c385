// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/mesh/msh.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/coupled_run.hpp"

/// The lid-driven cavity with a flexible bottom of Wall (1999) and Mok (2001), as fully defined by Valdes
/// (2007): a unit square, lid and linear inflow at 0.875 < y < 1 with 1 - cos(2 pi t/5), p = 0 on the other
/// side there, a membrane h = 0.002, E = 250, rho_s = 500 below, rho = 1, nu = 0.01. Vertical displacement of
/// its middle, of period 5.
namespace drogue::test {
namespace {

constexpr double period = 5;

struct Cavity {
  int cells = 32;
  double time_step = 0.1;
  double end = 60;
  std::string acceleration = "relaxation: 0.5 reuse_steps: 5 filter: 0.1";
};

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
                     "structure {{ command: 'structure_solver' config: 'structure.textproto' }}\n"
                     "mesh_mover {{ command: 'mesh_mover' config: 'mesh.textproto' }}\n"
                     "fluid {{ command: 'fluid_solver' config: 'fluid.textproto' }}\n"
                     "time {{ step: {} steps: {} }}\n"
                     "loop {{ relative: 1e-6 max_iterations: 60 }}\n"
                     "acceleration {{ {} }}\n"
                     "outer_boundary: FIXED\n",
                     c.time_step, std::lround(c.end / c.time_step), c.acceleration);
}

struct Answer {
  CoupledRun run;
  std::vector<double> t, y; ///< of the middle
};

Answer run(const std::string& name, const Cavity& c) {
  const auto folder = fresh_folder(name);
  write_case(folder, c);
  CoupledRun coupled = run_coupled(folder, std::chrono::minutes(240));
  const Table probe = read_csv(folder / "run/structure/probes.csv");
  return {std::move(coupled), column(probe, "time"), column(probe, "middle_y")};
}

/// Where the displacement turns, by parabolas through the samples.
void print_extremes(const Answer& a, double until) {
  for (std::size_t i = 1; i + 1 < a.y.size() && a.t[i] < until; ++i) {
    const double before = a.y[i - 1], here = a.y[i], after = a.y[i + 1];
    if ((here - before) * (after - here) > 0) continue;
    const double shift = 0.5 * (before - after) / (before - 2 * here + after);
    fmt::print("  {} {:.4f} at t = {:.2f}\n", here > before ? "max" : "min",
               here - 0.25 * (before - after) * shift, a.t[i] + shift * (a.t[i] - a.t[i - 1]));
  }
}

/// The bands of the published runs of this definition, each +- 5 %, over the last period.
void verify_periodic(const std::string& name, const Cavity& c) {
  const Answer a = run(name, c);
  print_extremes(a, 25);
  const auto samples = static_cast<std::size_t>(std::lround(period / c.time_step));
  ASSERT_GE(a.y.size(), samples);
  const auto first = a.y.end() - static_cast<std::ptrdiff_t>(samples);
  double mean = 0;
  for (auto y = first; y != a.y.end(); ++y) mean += *y / static_cast<double>(samples);
  const std::string id = "coupler/" + name;
  verify_between(id, "peak", *std::max_element(first, a.y.end()), 0.95 * 0.2619, 1.05 * 0.2769);
  verify_between(id, "trough", *std::min_element(first, a.y.end()), 0.95 * 0.1967, 1.05 * 0.2033);
  verify_between(id, "mean", mean, 0.95 * 0.2316, 1.05 * 0.2466);
  verify_between(id, "iterations_iqn_ils", a.run.mean_iterations(), 0, 6);
}

TEST(FlexibleCavity, IsPeriodicWith16Cells) {
  verify_periodic("flexible_cavity_16", {.cells = 16});
}

TEST(FlexibleCavity, IsPeriodicWith32Cells) {
  verify_periodic("flexible_cavity_32", {});
}

TEST(FlexibleCavity, IsPeriodicWith32CellsInHalfTheStep) {
  verify_periodic("flexible_cavity_32_half_step", {.time_step = 0.05});
}

TEST(FlexibleCavity, ByAitken) {
  const Answer a = run("aitken", {.end = 20, .acceleration = "method: AITKEN relaxation: 0.5"});
  verify_between("coupler/flexible_cavity_32", "iterations_aitken", a.run.mean_iterations(), 0, 12);
}

} // namespace
} // namespace drogue::test
