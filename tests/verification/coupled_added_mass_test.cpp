// SPDX-License-Identifier: GPL-3.0-or-later
// A taut membrane between two layers of ideal fluid against the exact added mass.
//
// Membrane y = 0, mass m_s a length, tension T, held at x = 0 and L; layers of height H above and below it,
// p = 0 at x = 0 and L. Small amplitude: w = a sin(kx) cos(omega t), k = pi / L, and
//   omega^2 = T k^2 / (m_s + m_f),  m_f = 2 rho coth(kH) / k.
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

constexpr double L = 1, H = 0.5, rho = 1, tension = 1, amplitude = 1e-3, k = std::numbers::pi / L;

double fluid_mass() {
  return 2 * rho / (std::tanh(k * H) * k);
}

struct Layers {
  double ratio = 10; ///< fluid's mass over the membrane's
  int along = 20;    ///< fluid edges on the membrane; half as many across each layer
  int steps_a_period = 40;
  int steps = 60;
  std::string loop = "relative: 1e-4";
  std::string acceleration = "relaxation: 0.1";
  std::string fluid = {};     ///< further fields
  std::string structure = {}; ///< further fields

  [[nodiscard]] double membrane_mass() const { return fluid_mass() / ratio; }
  [[nodiscard]] double omega() const { return std::sqrt(tension * k * k / (membrane_mass() + fluid_mass())); }
  [[nodiscard]] double dt() const { return 2 * std::numbers::pi / omega() / steps_a_period; }
};

void write_meshes(const std::filesystem::path& folder, const Layers& c) {
  mesh::Mesh fluid;
  add_layer(fluid, L, c.along, finer_towards(0, -H, c.along / 2), "floor", "below");
  std::vector<double> heights = finer_towards(0, H, c.along / 2);
  std::reverse(heights.begin(), heights.end());
  add_layer(fluid, L, c.along, heights, "above", "ceiling");
  ASSERT_TRUE(mesh::write_msh(folder / "fluid.msh", fluid).ok());

  const int n = c.along;
  mesh::Mesh membrane;
  for (int i = 0; i <= n; ++i) membrane.points.insert(membrane.points.end(), {L * i / n, 0.0, 0.0});
  mesh::ElementBlock lines{"membrane", mesh::ElementKind::line2, {}};
  for (int i = 0; i < n; ++i) lines.nodes.insert(lines.nodes.end(), {i, i + 1});
  membrane.blocks = {lines, {"ends", mesh::ElementKind::point1, {0, n}}};
  ASSERT_TRUE(mesh::write_msh(folder / "structure.msh", membrane).ok());

  const auto nodes = static_cast<std::uint64_t>(n) + 1;
  std::vector<double> d(3 * nodes, 0.0);
  for (std::size_t i = 0; i < nodes; ++i) d[3 * i + 1] = amplitude * std::sin(k * membrane.points[3 * i]);
  io::State state{"structure", mesh::hash(membrane), 0, 0, {}};
  state.add("displacement", {nodes, 3}, d);
  for (const char* rate : {"velocity", "acceleration"})
    state.add(rate, {nodes, 3}, std::vector<double>(3 * nodes, 0.0));
  ASSERT_TRUE(io::write_state(folder / "start.state", state).ok());
}

void write_solvers(const std::filesystem::path& folder, const Layers& c) {
  std::ofstream(folder / "structure.textproto") << fmt::format(
      "mesh: 'structure.msh' initial_state: 'start.state' interface: 'membrane' plane: true\n"
      "truss {{ group: 'membrane' area: 0.001 density: {} youngs_modulus: 10 prestress: {} }}\n"
      "support {{ group: 'ends' components: 'y' }}\n"
      "support {{ group: 'membrane' components: 'x' }}\n"
      "time {{ step: {} rho_infinity: 0.9 balanced_start: true }}\n"
      "newton {{ displacement_tolerance: 1e-12 }}\n"
      "output {{ field_interval: 0 }}\n{}",
      c.membrane_mass() / 0.001, tension / 0.001, c.dt(), c.structure);
  std::ofstream(folder / "fluid.textproto")
      << fmt::format("mesh: 'fluid.msh' density: {} dynamic_viscosity: 1e-6\n"
                     "phase {{ formulation: DSD_SST step: {} }}\n"
                     "newton {{ jacobian_lag: 100 }}\n"
                     "boundary {{ name: 'above' no_slip {{ components: 'y' }} }}\n"
                     "boundary {{ name: 'below' no_slip {{ components: 'y' }} }}\n"
                     "boundary {{ name: 'floor' free_slip {{}} }}\n"
                     "boundary {{ name: 'ceiling' free_slip {{}} }}\n"
                     "boundary {{ name: 'ends' traction_free {{ backflow: 0 }} }}\n"
                     "interface: 'above' interface: 'below'\n"
                     "output {{ field_interval: 0 }}\n{}",
                     rho, c.dt(), c.fluid);
  std::ofstream(folder / "mesh.textproto") << "mesh: 'fluid.msh' tolerance: 1e-8\n"
                                              "boundary { name: 'above' displacement {} }\n"
                                              "boundary { name: 'below' displacement {} }\n"
                                              "boundary { name: 'floor' fixed {} }\n"
                                              "boundary { name: 'ceiling' fixed {} }\n"
                                              "boundary { name: 'ends' sliding { normal: 'x' } }\n"
                                              "interface: 'above' interface: 'below'\n"
                                              "output { field_interval: 0 }\n";
  std::ofstream(folder / "case.textproto")
      << fmt::format("name: 'membrane between layers' run_directory: 'run'\n"
                     "structure {{ command: 'structure_solver' config: 'structure.textproto' }}\n"
                     "mesh_mover {{ command: 'mesh_mover' config: 'mesh.textproto' }}\n"
                     "fluid {{ command: 'fluid_solver' config: 'fluid.textproto' }}\n"
                     "time {{ step: {} steps: {} }}\n"
                     "loop {{ {} }}\nacceleration {{ {} }}\n"
                     "outer_boundary: FIXED\n",
                     c.dt(), c.steps, c.loop, c.acceleration);
}

struct Answer {
  CoupledRun run;
  std::string output;
  Swing swing;
};

Answer swing(const std::string& name, const Layers& c) {
  const auto folder = fresh_folder(name);
  write_meshes(folder, c);
  write_solvers(folder, c);
  Answer answer{run_coupled(folder, std::chrono::minutes(60)), read_text(folder / "output.txt"), {}};
  answer.swing =
      fitted(column(answer.run.steps, "time"), column(answer.run.steps, "mean_displacement_y"), c.omega());
  fmt::print("{}: omega {:+.3f} %, decay {:.3f} % a period, {:.2f} iterations a step, {:.0f} at most\n", name,
             100 * (answer.swing.omega / c.omega() - 1), 100 * answer.swing.decay,
             answer.run.mean_iterations(), answer.run.most_iterations());
  return answer;
}

void verify_swing(const std::string& name, const Layers& c) {
  const Answer a = swing(name, c);
  const std::string id = "coupler/" + name;
  verify_relative(id, "omega", a.swing.omega, c.omega(), 0.01);
  verify(id, "decay_per_period", a.swing.decay, 0, 0.02);
  verify(id, "iterations", a.run.mean_iterations(), 0, 10);
  const auto found = a.output.find("answers with about ");
  ASSERT_NE(found, std::string::npos) << a.output;
  // H answers a change of the displacement by -m_f/(m_s + beta dt^2 T k^2), beta about 1/4.
  const double resistance = c.membrane_mass() + 0.25 * c.dt() * c.dt() * tension * k * k;
  verify_relative(id, "estimated_mass_ratio", std::stod(a.output.substr(found + 19)),
                  fluid_mass() / resistance, 0.15);
  EXPECT_NE(a.output.find(c.ratio < 3 ? "AITKEN or IQN_ILS" : "IQN_ILS or IQN_IMVJ"), std::string::npos)
      << a.output;
}

#ifndef DROGUE_FINE
/// The membrane in three steps of its own to one of the fluid's.
TEST(AddedMass, OfTenTimesAMembraneInSmallerSteps) {
  const std::string name = "layers_membrane_in_parts";
  const Layers c{.steps = 50, .structure = "subcycling { parts: 3 }\n"};
  const Answer a = swing(name, c);
  verify_relative("coupler/" + name, "omega", a.swing.omega, c.omega(), 0.01);
  verify("coupler/" + name, "decay_per_period", a.swing.decay, 0, 0.02);
  verify("coupler/" + name, "iterations", a.run.mean_iterations(), 0, 10);
}

TEST(AddedMass, OfTenTimesTheMembrane) {
  verify_swing("layers_mass_10_coarse", {.steps = 50});
}
#else
TEST(AddedMass, OfOneToAHundredTimesTheMembrane) {
  for (const int ratio : {1, 10, 100})
    verify_swing(fmt::format("layers_mass_{}", ratio),
                 {.ratio = static_cast<double>(ratio), .along = 32, .steps = 80});
}

/// The consistent pairs of wall velocity and load, with step refinement: the lag of the load damps.
TEST(AddedMass, ByPairOfWallVelocityAndLoad) {
  const auto decays = [](const std::string& pair, const std::string& loop) {
    std::vector<double> found;
    for (const int steps : {20, 40, 80}) {
      const Layers c{
          .along = 16, .steps_a_period = steps, .steps = 3 * steps / 2, .loop = "relative: 1e-4 " + loop};
      const std::string name = fmt::format("pair_{}_{}", pair, steps);
      found.push_back(swing(name, c).swing.decay);
      verify("coupler/layers", name + "_decay", found.back(), 0,
             pair == "extrapolated" ? 16.0 / (steps * steps) : 20.0 / steps);
    }
    return found;
  };
  const auto best = decays("extrapolated", ""), end = decays("end", "load: END_OF_STEP"),
             mean = decays("mean", "load: MEAN_OF_STEP"),
             mesh = decays("mesh_rate", "wall_velocity: MESH_RATE");
  for (std::size_t i = 0; i < best.size(); ++i) {
    EXPECT_LT(std::abs(best[i]), 0.2 * end[i]);
    EXPECT_LT(end[i], 1.2 * mean[i]);
    EXPECT_LT(mean[i], 1.2 * mesh[i]);
  }
}

TEST(AddedMass, ByAccelerator) {
  const auto iterations = [](const std::string& name, int ratio, const std::string& scheme,
                             const std::string& acceleration) {
    const Layers c{.ratio = static_cast<double>(ratio),
                   .along = 16,
                   .steps = 12,
                   .loop = "relative: 1e-4 max_iterations: 100 stall: 0 non_convergence: ACCEPT "
                           "scheme: " +
                           scheme,
                   .acceleration = fmt::format("{} relaxation: {}", acceleration, 0.9 / (1 + ratio))};
    return swing(fmt::format("{}_mass_{}", name, ratio), c).run.mean_iterations();
  };
  for (const int ratio : {1, 10, 100}) {
    if (ratio < 100) (void)iterations("constant", ratio, "SERIAL", "method: CONSTANT");
    const double aitken = iterations("aitken", ratio, "SERIAL", "method: AITKEN"),
                 alone = iterations("iqn_ils_without_reuse", ratio, "SERIAL", "reuse_steps: 0"),
                 ils = iterations("iqn_ils", ratio, "SERIAL", ""),
                 imvj = iterations("iqn_imvj", ratio, "SERIAL", "method: IQN_IMVJ");
    (void)iterations("structure_first_iqn_ils", ratio, "STRUCTURE_FIRST", "");
    (void)iterations("parallel_iqn_ils", ratio, "PARALLEL", "");
    (void)iterations("parallel_iqn_imvj", ratio, "PARALLEL", "method: IQN_IMVJ");
    if (ratio == 1) continue; // there any of them does
    EXPECT_LT(ils, alone);
    EXPECT_LT(imvj, alone);
    EXPECT_LT(alone, aitken);
  }
}
#endif

} // namespace
} // namespace drogue::test
