// SPDX-License-Identifier: GPL-3.0-or-later
// Two taut membranes that swing through the ideal fluid between them: two bodies, two interfaces, one fluid;
// both bodies in one structure program, or each in a program of its own.
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
constexpr int all_steps = 60, steps_a_period = 40;

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

/// Membranes at these heights, with their start: NAME.msh and NAME.state.
void write_membranes(const std::filesystem::path& folder, const std::string& name,
                     const std::vector<double>& at_heights) {
  constexpr int n = structure_edges;
  mesh::Mesh membranes;
  mesh::ElementBlock lines{"membranes", mesh::ElementKind::line2, {}},
      ends{"ends", mesh::ElementKind::point1, {}};
  for (const double y : at_heights) {
    const std::int32_t first = membranes.node_count();
    for (int i = 0; i <= n; ++i) membranes.points.insert(membranes.points.end(), {L * i / n, y, 0.0});
    for (int i = 0; i < n; ++i) lines.nodes.insert(lines.nodes.end(), {first + i, first + i + 1});
    ends.nodes.insert(ends.nodes.end(), {first, first + n});
  }
  membranes.blocks = {lines, ends};
  ASSERT_TRUE(mesh::write_msh(folder / (name + ".msh"), membranes).ok());

  const auto nodes = static_cast<std::uint64_t>(membranes.node_count());
  std::vector<double> d(3 * nodes, 0.0);
  for (std::size_t i = 0; i < nodes; ++i)
    if (membranes.points[3 * i + 1] > 0) d[3 * i + 1] = amplitude * std::sin(k * membranes.points[3 * i]);
  io::State state{"structure", mesh::hash(membranes), 0, 0, {}};
  state.add("displacement", {nodes, 3}, d);
  for (const char* rate : {"velocity", "acceleration"})
    state.add(rate, {nodes, 3}, std::vector<double>(3 * nodes, 0.0));
  ASSERT_TRUE(io::write_state(folder / (name + ".state"), state).ok());
}

/// NAME.textproto of membranes at these heights, with a probe, 'low' or 'up', in the middle of each.
void write_structure(const std::filesystem::path& folder, const std::string& name,
                     const std::vector<double>& at_heights) {
  write_membranes(folder, name, at_heights);
  std::ofstream config(folder / (name + ".textproto"));
  config << fmt::format(
      "mesh: '{0}.msh' initial_state: '{0}.state' interface: 'membranes' plane: true\n"
      "truss {{ group: 'membranes' area: 0.001 density: {1} youngs_modulus: 10 prestress: {2} }}\n"
      "support {{ group: 'ends' components: 'y' }}\n"
      "support {{ group: 'membranes' components: 'x' }}\n"
      "time {{ step: {3} rho_infinity: 0.9 balanced_start: true }}\n"
      "newton {{ displacement_tolerance: 1e-12 }}\n"
      "output {{ field_interval: 0 }}\n",
      name, membrane_mass / 0.001, tension / 0.001, dt());
  for (const double y : at_heights)
    config << fmt::format("probe {{ name: '{}' x: 0.5 y: {} z: 0 }}\n", y > 0 ? "up" : "low", y);
}

void write_fluid_mesh(const std::filesystem::path& folder) {
  std::vector<double> heights;
  constexpr int half = 8;
  for (int j = -half; j <= half; ++j) { // finer towards both membranes
    const double s = static_cast<double>(std::abs(j)) / half;
    heights.push_back(std::copysign(H * (1.5 * s - 0.5 * s * s), j));
  }
  mesh::Mesh fluid;
  add_layer(fluid, L, fluid_edges, heights, "low", "high");
  ASSERT_TRUE(mesh::write_msh(folder / "fluid.msh", fluid).ok());
}

void write_fluid(const std::filesystem::path& folder) {
  write_fluid_mesh(folder);
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
}

/// @param structures their entries in the case
void write_case(const std::filesystem::path& folder, const std::string& structures, int steps) {
  std::ofstream(folder / "case.textproto")
      << fmt::format("name: 'two membranes' run_directory: 'run'\n{}"
                     "mesh_mover {{ command: 'mesh_mover' config: 'mesh.textproto' }}\n"
                     "fluid {{ command: 'fluid_solver' config: 'fluid.textproto' }}\n"
                     "time {{ step: {} steps: {} }}\n"
                     "loop {{ relative: 1e-4 }}\nacceleration {{ relaxation: 0.1 }}\n"
                     "outer_boundary: FIXED\n",
                     structures, dt(), steps);
}

/// Runs both membranes in one program, in `folder`.
CoupledRun run_in_one(const std::filesystem::path& folder, int steps) {
  write_structure(folder, "structure", {-H, H});
  write_fluid(folder);
  write_case(folder, "structure { command: 'structure_solver' config: 'structure.textproto' }\n", steps);
  return run_coupled(folder, std::chrono::minutes(10));
}

TEST(TwoMembranes, SwingThroughTheFluidBetweenThem) {
  const auto folder = fresh_folder("run");
  const CoupledRun run = run_in_one(folder, all_steps);
  const Table probes = read_csv(folder / "run/structure/probes.csv");
  const std::vector<double> t = column(probes, "time"), up = column(probes, "up_y"),
                            low = column(probes, "low_y");
  ASSERT_GE(t.size(), static_cast<std::size_t>(all_steps));
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

/// Largest difference of a probe's motion in two runs, relative to the amplitude.
double difference(const std::filesystem::path& a, const std::filesystem::path& b, const std::string& probe) {
  const std::vector<double> of_a = column(read_csv(a / "probes.csv"), probe),
                            of_b = column(read_csv(b / "probes.csv"), probe);
  EXPECT_FALSE(of_a.empty());
  EXPECT_EQ(of_a.size(), of_b.size());
  double largest = 0;
  for (std::size_t i = 0; i < std::min(of_a.size(), of_b.size()); ++i)
    largest = std::max(largest, std::abs(of_a[i] - of_b[i]));
  return largest / amplitude;
}

TEST(TwoMembranes, SwingAlikeInOneProgramAndInTwo) {
  constexpr int steps = 12;
  const auto one = fresh_folder("one"), two = fresh_folder("two");
  const CoupledRun together = run_in_one(one, steps);
  write_structure(two, "lower", {-H});
  write_structure(two, "upper", {H});
  write_fluid(two);
  write_case(two,
             "structure { name: 'lower' command: 'structure_solver' config: 'lower.textproto' }\n"
             "structure { name: 'upper' command: 'structure_solver' config: 'upper.textproto' }\n",
             steps);
  const CoupledRun apart = run_coupled(two, std::chrono::minutes(10));
  const std::string id = "coupler/two_structures";
  verify(id, "difference_of_the_upper", difference(one / "run/structure", two / "run/upper", "up_y"), 0,
         1e-6);
  verify(id, "difference_of_the_lower", difference(one / "run/structure", two / "run/lower", "low_y"), 0,
         1e-6);
  verify(id, "difference_of_iterations", apart.mean_iterations() - together.mean_iterations(), 0, 1e-12);
}

} // namespace
} // namespace drogue::test
