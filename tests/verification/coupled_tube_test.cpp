// SPDX-License-Identifier: GPL-3.0-or-later
// A pressure pulse in a thin elastic tube of membrane elements, filled with ideal fluid.
//
// Radius R, wall h = R/50, nu = 0, held along the axis z, kept taut by a base pressure that stretches it to
// the radius r = lambda R. A pulse longer than 20 R enters at z = 0. With the hoop tension of a St.
// Venant-Kirchhoff wall,
//   p = E h (lambda^2 - 1) / (2 R),  c^2 = (r / 2 rho) dp/dr = E h lambda^2 / (2 rho R).
// The time at which the pulse's centre of gravity passes a place goes with the speed of the longest waves,
// whatever the dispersion: its time of flight between two places gives c. Units: R = rho = c = 1.
#include <cmath>
#include <limits>
#include <numbers>

#include "common/io/state_file.hpp"
#include "common/mesh/msh.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/coupled_run.hpp"
#include "tests/verification/disc_mesh.hpp"
#include "tests/verification/fluid_meshes.hpp"

namespace drogue::test {
namespace {

constexpr double h = 0.02, lambda = 1.1, length = 24, pulse = 24;
constexpr double rise = 1e-3; // of the radius, about: the pulse's largest pressure over dp/dr
constexpr double youngs_modulus = 2 / (h * lambda * lambda);
constexpr double near_end = 3, far_end = 11; // where the pulse is timed

struct Tube {
  int rings = 3; ///< of the fluid's cross-section: 6 rings edges around
  double wall_density = 1;
  double dt = 1;
  std::string loop = "relative: 1e-4 floor: 1e-8";
  std::string acceleration = "relaxation: 0.002 reuse_steps: 100";
  double end = far_end + pulse + 1; ///< before the far end of the tube answers
};

/// The wall of the fluid's mesh, with the radius R, and the displacement of its nodes to lambda R.
void write_structure_mesh(const std::filesystem::path& folder, const mesh::Mesh& fluid) {
  const std::vector<std::int32_t> wall = fluid.nodes_of("wall");
  std::vector<std::int32_t> number(static_cast<std::size_t>(fluid.node_count()), -1);
  mesh::Mesh m;
  mesh::ElementBlock tube{"tube", mesh::ElementKind::tri3, {}}, ends{"ends", mesh::ElementKind::point1, {}};
  std::vector<double> d;
  for (const std::int32_t node : wall) {
    const double* x = &fluid.points[3 * static_cast<std::size_t>(node)];
    const std::int32_t own = number[static_cast<std::size_t>(node)] = m.node_count();
    m.points.insert(m.points.end(), {x[0] / lambda, x[1] / lambda, x[2]});
    d.insert(d.end(), {x[0] * (1 - 1 / lambda), x[1] * (1 - 1 / lambda), 0});
    if (x[2] < 1e-9 || x[2] > length - 1e-9) ends.nodes.push_back(own);
  }
  for (const std::int32_t node : fluid.blocks_of("wall")[0]->nodes)
    tube.nodes.push_back(number[static_cast<std::size_t>(node)]);
  for (std::size_t e = 0; e < tube.nodes.size(); e += 3) { // normals outward
    const auto X = [&](std::size_t k, int c) {
      return m.points[3 * static_cast<std::size_t>(tube.nodes[e + k]) + static_cast<std::size_t>(c)];
    };
    const double n_x = (X(1, 1) - X(0, 1)) * (X(2, 2) - X(0, 2)) - (X(1, 2) - X(0, 2)) * (X(2, 1) - X(0, 1));
    const double n_y = (X(1, 2) - X(0, 2)) * (X(2, 0) - X(0, 0)) - (X(1, 0) - X(0, 0)) * (X(2, 2) - X(0, 2));
    if (n_x * (X(0, 0) + X(1, 0) + X(2, 0)) + n_y * (X(0, 1) + X(1, 1) + X(2, 1)) < 0)
      std::swap(tube.nodes[e + 1], tube.nodes[e + 2]);
  }
  m.blocks = {tube, ends};
  ASSERT_TRUE(mesh::write_msh(folder / "structure.msh", m).ok());

  const auto nodes = static_cast<std::uint64_t>(m.node_count());
  io::State state{"structure", mesh::hash(m), 0, 0, {}};
  state.add("displacement", {nodes, 3}, d);
  for (const char* rate : {"velocity", "acceleration"})
    state.add(rate, {nodes, 3}, std::vector<double>(3 * nodes, 0.0));
  ASSERT_TRUE(io::write_state(folder / "start.state", state).ok());
}

void write_meshes(const std::filesystem::path& folder, const Tube& c) {
  std::vector<double> radii, z;
  for (int k = 1; k <= c.rings; ++k) radii.push_back(lambda * k / c.rings);
  const int along = static_cast<int>(std::lround(length * c.rings / 3));
  for (int k = 0; k <= along; ++k) z.push_back(length * k / along);
  const mesh::Mesh fluid = fluid::test::extruded(disc_mesh(radii, c.rings), z);
  ASSERT_TRUE(mesh::write_msh(folder / "fluid.msh", fluid).ok());
  write_structure_mesh(folder, fluid);
}

void write_solvers(const std::filesystem::path& folder, const Tube& c) {
  // A tube of 6 n plane strips carries its hoop tension at the pressure T / (r cos(pi / 6 n)).
  const double base =
      youngs_modulus * h * (lambda * lambda - 1) / 2 / std::cos(std::numbers::pi / (6 * c.rings));
  const double step = youngs_modulus * h * lambda * rise;
  std::ofstream(folder / "structure.textproto") << fmt::format(
      "mesh: 'structure.msh' initial_state: 'start.state' initial_at_rest: true interface: 'tube'\n"
      "membrane {{ group: 'tube' thickness: {} density: {} youngs_modulus: {} poisson_ratio: 0 }}\n"
      "pressure {{ group: 'tube' value: '{}' }}\n"
      "support {{ group: 'tube' components: 'z' }}\n"
      "support {{ group: 'ends' components: 'xy' displacement {{ x: '{}*x' y: '{}*y' }} }}\n"
      "time {{ step: {} }}\n"
      "newton {{ displacement_tolerance: 1e-10 load_stiffness: true iterations_per_coupling: 1 }}\n"
      "probe {{ name: 'near' x: 1 y: 0 z: {} }} probe {{ name: 'far' x: 1 y: 0 z: {} }}\n"
      "output {{ field_interval: 0 }}\n",
      h, c.wall_density, youngs_modulus, base, lambda - 1, lambda - 1, c.dt, near_end, far_end);
  std::ofstream(folder / "fluid.textproto")
      << fmt::format("mesh: 'fluid.msh' density: 1 dynamic_viscosity: 1e-6\n"
                     "phase {{ formulation: DSD_SST step: {} }}\n"
                     "newton {{ jacobian_lag: 100 }} linear {{ tolerance: 1e-4 }}\n"
                     "boundary {{ name: 'wall' no_slip {{ components: 'xy' }} }}\n"
                     "boundary {{ name: 'z0' traction {{ z: 't < {} ? {}*(1-cos(2*pi*t/{}))/2 : 0' }} }}\n"
                     "boundary {{ name: 'z1' traction_free {{ backflow: 0 }} }}\n"
                     "interface: 'wall'\n"
                     "output {{ field_interval: 0 }}\n",
                     c.dt, pulse, step, pulse);
  std::ofstream(folder / "mesh.textproto") << "mesh: 'fluid.msh' tolerance: 1e-8 increment: FROM_INITIAL\n"
                                              "boundary { name: 'wall' displacement {} }\n"
                                              "boundary { name: 'z0' sliding { normal: 'z' } }\n"
                                              "boundary { name: 'z1' sliding { normal: 'z' } }\n"
                                              "interface: 'wall'\n"
                                              "output { field_interval: 0 }\n";
  std::ofstream(folder / "case.textproto")
      << fmt::format("name: 'pulse in a tube' run_directory: 'run'\n"
                     "structure {{ command: 'structure_solver' config: 'structure.textproto' }}\n"
                     "mesh_mover {{ command: 'mesh_mover' config: 'mesh.textproto' }}\n"
                     "fluid {{ command: 'fluid_solver' config: 'fluid.textproto' }}\n"
                     "time {{ step: {} steps: {} }}\n"
                     "loop {{ {} }}\nacceleration {{ {} }}\n"
                     "outer_boundary: FIXED\n",
                     c.dt, std::lround(c.end / c.dt), c.loop, c.acceleration);
}

void write_case(const std::filesystem::path& folder, const Tube& c) {
  write_meshes(folder, c);
  write_solvers(folder, c);
}

/// When the centre of gravity of a history passes.
double passage(const std::vector<double>& t, const std::vector<double>& w) {
  double sum = 0, moment = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    sum += w[i];
    moment += w[i] * t[i];
  }
  return moment / sum;
}

void verify_pulse(const std::string& name, const Tube& c) {
  const auto folder = fresh_folder(name);
  write_case(folder, c);
  const CoupledRun run = run_coupled(folder, std::chrono::minutes(60));
  const Table probes = read_csv(folder / "run/structure/probes.csv");
  const std::vector<double> t = column(probes, "time");
  const auto radius_change = [&](const std::string& probe) {
    std::vector<double> w = column(probes, probe + "_x");
    for (double& value : w) value -= lambda - 1;
    return w;
  };
  const double flight = passage(t, radius_change("far")) - passage(t, radius_change("near"));
  const std::string id = "coupler/" + name;
  verify_relative(id, "wave_speed", (far_end - near_end) / flight, 1, 0.03);
  verify_between(id, "iterations", run.mean_iterations(), 1, 12);
  fmt::print("{}: {:.0f} iterations at most\n", name, run.most_iterations());
}

/// One exchange a step: the largest change of the radius, over that of the converged pulse; infinite when the
/// run broke down.
double loose_growth(const std::string& name, Tube c) {
  c.loop = "relative: 1e-4 max_iterations: 1 non_convergence: ACCEPT";
  c.acceleration = "method: CONSTANT relaxation: 1";
  const auto folder = fresh_folder(name);
  write_case(folder, c);
  if (!ends_well(folder, std::chrono::minutes(60))) return std::numeric_limits<double>::infinity();
  double largest = 0;
  for (const double value : column(read_csv(folder / "run/structure/probes.csv"), "near_x"))
    largest = std::max(largest, std::abs(value - (lambda - 1)));
  return largest / rise;
}

#ifndef DROGUE_FINE
TEST(Tube, CarriesAPulse) {
  verify_pulse("tube", {});
  EXPECT_GT(loose_growth("loose", {}), 10);
}
#else
TEST(Tube, CarriesAPulseWhateverItsWallWeighs) {
  for (const double wall_density : {0.1, 1.0, 10.0}) {
    const Tube c{.rings = 4, .wall_density = wall_density};
    verify_pulse(fmt::format("tube_wall_density_{:g}", wall_density), c);
    EXPECT_GT(loose_growth("loose", c), 10);
  }
}
#endif

} // namespace
} // namespace drogue::test
