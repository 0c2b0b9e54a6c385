// SPDX-License-Identifier: GPL-3.0-or-later
// Two taut membranes that swing through the ideal fluid between them: two bodies, two interfaces, one fluid.
//
// Membranes y = H and y = -H, mass m_s a length, tension T, held at x = 0 and L; p = 0 at x = 0 and L. With
// w_up = a sin(kx) and w_low = 0 at the start, k = pi / L, the membranes' sum and difference swing apart:
//   w_up + w_low = a cos(omega_1 t) sin(kx),  omega_1^2 = T k^2 / (m_s + rho tanh(kH) / k),
//   w_up - w_low = a cos(omega_2 t) sin(kx),  omega_2^2 = T k^2 / (m_s + rho coth(kH) / k).
#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/io/state_file.hpp"
#include "common/mesh/msh.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/coupled_run.hpp"
#include "tests/verification/layer_mesh.hpp"
#include "tests/verification/swing.hpp"

namespace drogue::test {
namespace {

constexpr double L = 1, H = 0.25, rho = 1, tension = 1, amplitude = 1e-3, k = std::numbers::pi / L;
constexpr int fluid_edges = 24, structure_edges = 20; // along a membrane: they do not match
constexpr int steps = 60, steps_a_period = 40;

double mass_of_sum() {
  return rho * std::tanh(k * H) / k;
}
double mass_of_difference() {
  return rho / (std::tanh(k * H) * k);
}
constexpr double membrane_mass = 0.05;

double omega(double fluid_mass) {
  return std::sqrt(tension * k * k / (membrane_mass + fluid_mass));
}
double dt() {
  return 2 * std::numbers::pi / omega(mass_of_sum()) / steps_a_period;
}

void write_meshes(const std::filesystem::path& folder) {
  std::vector<double> heights;
  constexpr int half = 8;
  for (int j = -half; j <= half; ++j) { // finer towards both membranes
    const double s = static_cast<double>(std::abs(j)) / half;
    heights.push_back(std::copysign(H * (1.5 * s - 0.5 * s * s), j));
  }
  mesh::Mesh fluid;
  add_layer(fluid, L, fluid_edges, heights, "low", "high");
  ASSERT_TRUE(mesh::write_msh(folder / "fluid.msh", fluid).ok());

  constexpr int n = structure_edges;
  mesh::Mesh membranes;
  mesh::ElementBlock lines{"membranes", mesh::ElementKind::line2, {}},
      ends{"ends", mesh::ElementKind::point1, {}};
  for (const double y : {-H, H}) {
    const std::int32_t first = membranes.node_count();
    for (int i = 0; i <= n; ++i) membranes.points.insert(membranes.points.end(), {L * i / n, y, 0.0});
    for (int i = 0; i < n; ++i) lines.nodes.insert(lines.nodes.end(), {first + i, first + i + 1});
    ends.nodes.insert(ends.nodes.end(), {first, first + n});
  }
  membranes.blocks = {lines, ends};
  ASSERT_TRUE(mesh::write_msh(folder / "structure.msh", membranes).ok());

  const auto nodes = static_cast<std::uint64_t>(membranes.node_count());
  std::vector<double> d(3 * nodes, 0.0);
  for (std::size_t i = 0; i < nodes; ++i)
    if (membranes.points[3 * i + 1] > 0) d[3 * i + 1] = amplitude * std::sin(k * membranes.points[3 * i]);
  io::State state{"structure", mesh::hash(membranes), 0, 0, {}};
  state.add("displacement", {nodes, 3}, d);
  for (const char* rate : {"velocity", "acceleration"})
    state.add(rate, {nodes, 3}, std::vector<double>(3 * nodes, 0.0));
  ASSERT_TRUE(io::write_state(folder / "start.state", state).ok());
}

void write_solvers(const std::filesystem::path& folder) {
  std::ofstream(folder / "structure.textproto") << fmt::format(
      "mesh: 'structure.msh' initial_state: 'start.state' interface: 'membranes' plane: true\n"
      "truss {{ group: 'membranes' area: 0.001 density: {} youngs_modulus: 10 prestress: {} }}\n"
      "support {{ group: 'ends' components: 'y' }}\n"
      "support {{ group: 'membranes' components: 'x' }}\n"
      "time {{ step: {} rho_infinity: 0.9 balanced_start: true }}\n"
      "newton {{ displacement_tolerance: 1e-12 }}\n"
      "probe {{ name: 'up' x: 0.5 y: {} z: 0 }}\n"
      "probe {{ name: 'low' x: 0.5 y: {} z: 0 }}\n"
      "output {{ field_interval: 0 }}\n",
      membrane_mass / 0.001, tension / 0.001, dt(), H, -H);
  std::ofstream(folder / "fluid.textproto")
      << fmt::format("mesh: 'fluid.msh' density: {} dynamic_viscosity: 1e-6\n"
                     "phase {{ formulation: DSD_SST step: {} }}\n"
                     "newton {{ jacobian_lag: 100 }}\n"
                     "boundary {{ name: 'low' no_slip {{ components: 'y' }} }}\n"
                     "boundary {{ name: 'high' no_slip {{ components: 'y' }} }}\n"
                     "boundary {{ name: 'ends' traction_free {{ backflow: 0 }} }}\n"
                     "interface: 'low' interface: 'high'\n"
                     "output {{ field_interval: 0 }}\n",
                     rho, dt());
  std::ofstream(folder / "mesh.textproto") << "mesh: 'fluid.msh' tolerance: 1e-8\n"
                                              "boundary { name: 'low' displacement {} }\n"
                                              "boundary { name: 'high' displacement {} }\n"
                                              "boundary { name: 'ends' sliding { normal: 'x' } }\n"
                                              "interface: 'low' interface: 'high'\n"
                                              "output { field_interval: 0 }\n";
  std::ofstream(folder / "case.textproto")
      << fmt::format("name: 'two membranes' run_directory: 'run'\n"
                     "structure {{ command: 'structure_solver' config: 'structure.textproto' }}\n"
                     "mesh_mover {{ command: 'mesh_mover' config: 'mesh.textproto' }}\n"
                     "fluid {{ command: 'fluid_solver' config: 'fluid.textproto' }}\n"
                     "time {{ step: {} steps: {} }}\n"
                     "loop {{ relative: 1e-4 }}\nacceleration {{ relaxation: 0.1 }}\n"
                     "outer_boundary: FIXED\n",
                     dt(), steps);
}

TEST(TwoMembranes, SwingThroughTheFluidBetweenThem) {
  const auto folder = fresh_folder("run");
  write_meshes(folder);
  write_solvers(folder);
  const CoupledRun run = run_coupled(folder, std::chrono::minutes(10));
  const Table probes = read_csv(folder / "run/structure/probes.csv");
  const std::vector<double> t = column(probes, "time"), up = column(probes, "up_y"),
                            low = column(probes, "low_y");
  ASSERT_GE(t.size(), static_cast<std::size_t>(steps));
  std::vector<double> sum, difference;
  for (std::size_t i = 0; i < t.size(); ++i) {
    sum.push_back(up[i] + low[i]);
    difference.push_back(up[i] - low[i]);
  }
  double far = 0; // the fluid alone brings the lower one to swing
  for (const double w : low) far = std::max(far, std::abs(w));
  const double omega_1 = omega(mass_of_sum()), omega_2 = omega(mass_of_difference());
  double exact_far = 0;
  for (const double time : t)
    exact_far =
        std::max(exact_far, 0.5 * amplitude * std::abs(std::cos(omega_1 * time) - std::cos(omega_2 * time)));
  const std::string id = "coupler/two_membranes";
  verify_relative(id, "omega_of_sum", fitted(t, sum, omega_1).omega, omega_1, 0.01);
  verify_relative(id, "omega_of_difference", fitted(t, difference, omega_2).omega, omega_2, 0.01);
  verify_relative(id, "swing_of_the_one_at_rest", far, exact_far, 0.03);
  verify_between(id, "iterations", run.mean_iterations(), 0, 6);
}

} // namespace
} // namespace drogue::test
