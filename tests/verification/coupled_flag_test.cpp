// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "common/mesh/msh.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/coupled_run.hpp"
#include "tests/verification/fluid_case.hpp"
#include "tests/verification/fluid_meshes.hpp"

/// An elastic flag behind a cylinder in a channel: FSI1 to FSI3 of Turek and Hron (2006). Displacement of the
/// middle of the flag's end in m, forces per unit depth on cylinder and flag; references of the FeatFlow
/// group's finest levels: mean and amplitude are (max +- min)/2 of the last period. In FSI2 and FSI3 the
/// inflow starts in a quarter of the paper's time, and a push across at its end starts the swinging: the
/// periodic state is the same.
namespace drogue::test {
namespace {

namespace fluid = drogue::fluid::test;

struct Flag {
  std::string name;
  double mean_speed = 0;
  double flag_density = 0;
  double youngs_modulus = 0;
  fluid::FlagSizes sizes;
  int along = 0; ///< elements of the flag; a twelfth across
  double time_step = 0;
  double end = 0;         ///< time
  double ramp = 2;        ///< time in which the inflow starts
  std::string kick = "0"; ///< acceleration across, starts the swinging
  double rho_infinity = 0.8;
  std::string criterion = "relative: 1e-3";
  bool mirrored = false; ///< a fluid mesh that is mirrored in the flag's axis
};

/// Nine-node quadrilaterals, `along` x `across`; its left end lies on the cylinder.
mesh::Mesh flag_mesh(int along, int across) {
  mesh::Mesh m;
  const int columns = 2 * along + 1, rows = 2 * across + 1;
  const auto id = [columns](int i, int j) { return j * columns + i; };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const double y = 0.02 * (static_cast<double>(j) / (rows - 1) - 0.5);
      const double left = 0.2 + std::sqrt(0.05 * 0.05 - y * y);
      m.points.insert(m.points.end(), {left + (0.6 - left) * i / (columns - 1), 0.2 + y, 0.0});
    }
  mesh::ElementBlock flag{"flag", mesh::ElementKind::quad9, {}}, wet{"wet", mesh::ElementKind::line3, {}},
      root{"root", mesh::ElementKind::point1, {}};
  for (int j = 0; j + 2 < rows; j += 2)
    for (int i = 0; i + 2 < columns; i += 2)
      flag.nodes.insert(flag.nodes.end(),
                        {id(i, j), id(i + 2, j), id(i + 2, j + 2), id(i, j + 2), id(i + 1, j),
                         id(i + 2, j + 1), id(i + 1, j + 2), id(i, j + 1), id(i + 1, j + 1)});
  for (int i = 0; i + 2 < columns; i += 2)
    wet.nodes.insert(wet.nodes.end(), {id(i, 0), id(i + 2, 0), id(i + 1, 0)});
  for (int j = 0; j + 2 < rows; j += 2)
    wet.nodes.insert(wet.nodes.end(), {id(columns - 1, j), id(columns - 1, j + 2), id(columns - 1, j + 1)});
  for (int i = columns - 1; i > 0; i -= 2)
    wet.nodes.insert(wet.nodes.end(), {id(i, rows - 1), id(i - 2, rows - 1), id(i - 1, rows - 1)});
  for (int j = 0; j < rows; ++j) root.nodes.push_back(id(0, j));
  m.blocks = {flag, wet, root};
  return m;
}

void write_structure(const std::filesystem::path& folder, const Flag& f) {
  const mesh::Mesh m = flag_mesh(f.along, std::max(1, f.along / 12));
  ASSERT_TRUE(mesh::write_msh(folder / "structure.msh", m).ok());
  std::ofstream(folder / "structure.textproto")
      << fmt::format("mesh: 'structure.msh' plane: true interface: 'wet'\n"
                     "solid {{ group: 'flag' density: {} youngs_modulus: {} poisson_ratio: 0.4 }}\n"
                     "support {{ group: 'root' components: 'xy' }}\n"
                     "gravity {{ y: '{}' }}\n"
                     "time {{ step: {} rho_infinity: {} }}\n"
                     "newton {{ displacement_tolerance: 1e-10 }}\n"
                     "probe {{ name: 'A' x: 0.6 y: 0.2 z: 0 }}\n"
                     "output {{ field_interval: 0 }}\n",
                     f.flag_density, f.youngs_modulus, f.kick, f.time_step, f.rho_infinity);
}

void write_fluid(const std::filesystem::path& folder, const Flag& f) {
  const mesh::Mesh m =
      f.mirrored ? fluid::mirrored_flag_in_channel(f.sizes, true) : fluid::flag_in_channel(f.sizes, true);
  fmt::print("{}: {} fluid nodes\n", f.name, m.node_count());
  ASSERT_TRUE(mesh::write_msh(folder / "fluid.msh", m).ok());
  std::ofstream(folder / "fluid.textproto")
      << fmt::format("mesh: 'fluid.msh' density: 1000 dynamic_viscosity: 1\n"
                     "phase {{ formulation: DSD_SST step: {0} }}\n"
                     "stabilisation {{ viscous_residual: true }}\n"
                     "newton {{ jacobian_lag: 8 }}\n"
                     "boundary {{ name: 'inflow' velocity {{ x: '{2}*4*y*(0.41-y)/0.1681*(t < {1} ? "
                     "(1-cos(pi*t/{1}))/2 : 1)' }} }}\n"
                     "boundary {{ name: 'outflow' traction_free {{ backflow: 0 }} }}\n"
                     "boundary {{ name: 'bottom' no_slip {{}} }}\n"
                     "boundary {{ name: 'top' no_slip {{}} }}\n"
                     "boundary {{ name: 'obstacle' no_slip {{}} }}\n"
                     "boundary {{ name: 'plate' no_slip {{}} }}\n"
                     "interface: 'plate' interface_load: CONSISTENT_TRACTION\n"
                     "force {{ name: 'all' boundary: 'obstacle' boundary: 'plate' }}\n"
                     "output {{ field_interval: 0 }}\n",
                     f.time_step, f.ramp, 1.5 * f.mean_speed);
}

void write_rest(const std::filesystem::path& folder, const Flag& f) {
  std::ofstream(folder / "mesh.textproto") << "mesh: 'fluid.msh' increment: FROM_INITIAL\n"
                                              "boundary { name: 'plate' displacement {} }\n"
                                              "boundary { name: 'obstacle' fixed {} }\n"
                                              "boundary { name: 'inflow' fixed {} }\n"
                                              "boundary { name: 'outflow' fixed {} }\n"
                                              "boundary { name: 'bottom' fixed {} }\n"
                                              "boundary { name: 'top' fixed {} }\n"
                                              "interface: 'plate'\n"
                                              "output { field_interval: 0 }\n";
  std::ofstream(folder / "case.textproto")
      << fmt::format("name: '{}' run_directory: 'run'\n"
                     "structure {{ command: 'structure_solver' config: 'structure.textproto' }}\n"
                     "mesh_mover {{ command: 'mesh_mover' config: 'mesh.textproto' }}\n"
                     "fluid {{ command: 'fluid_solver' config: 'fluid.textproto' }}\n"
                     "time {{ step: {} steps: {} }}\n"
                     "loop {{ {} non_convergence: RETRY }}\n"
                     "acceleration {{ relaxation: 0.5 reuse_steps: 8 filter: 1e-1 }}\n"
                     "outer_boundary: FIXED\n",
                     f.name, f.time_step, std::lround(f.end / f.time_step), f.criterion);
}

struct History {
  std::vector<double> u_x, u_y, drag, lift;
};

/// A column at the ends of whole steps; steps that were done in halves have more rows.
std::vector<double> at_steps(const Table& table, const std::string& name, double time_step) {
  const std::vector<double> t = column(table, "time"), all = column(table, name);
  std::vector<double> values;
  for (std::size_t i = 0; i < t.size(); ++i)
    if (std::abs(t[i] / time_step - std::round(t[i] / time_step)) < 1e-6) values.push_back(all[i]);
  return values;
}

/// Runs the case; displacements of the flag's end, and forces as the discrete equations say, a value a step.
History run(const Flag& f) {
  const auto folder = fresh_folder(f.name.substr(f.name.find('/') + 1));
  write_structure(folder, f);
  write_fluid(folder, f);
  write_rest(folder, f);
  const CoupledRun coupled = run_coupled(folder, std::chrono::minutes(240));
  fmt::print("{}: {:.2f} iterations a step\n", f.name, coupled.mean_iterations(10));
  const Table probe = read_csv(folder / "run/structure/probes.csv");
  const Table force = read_csv(folder / "run/fluid/forces.csv");
  return {at_steps(probe, "A_x", f.time_step), at_steps(probe, "A_y", f.time_step),
          at_steps(force, "all_reaction_x", f.time_step), at_steps(force, "all_reaction_y", f.time_step)};
}

struct Swing {
  double mean, amplitude, mean_tolerance, amplitude_tolerance; ///< tolerances relative to the amplitude
};

struct SwingReference {
  Swing u_x, u_y, drag, lift;
  double frequency; ///< of u_y
};

void verify_swing(const std::string& name, const std::string& quantity, const fluid::Periodic& ours,
                  const Swing& reference) {
  verify(name, quantity + "_mean", ours.mean, reference.mean, reference.mean_tolerance * reference.amplitude);
  verify_relative(name, quantity + "_amplitude", ours.amplitude, reference.amplitude,
                  reference.amplitude_tolerance);
}

[[maybe_unused]] void verify_swinging(const Flag& f, const SwingReference& reference) {
  const History h = run(f);
  const auto last = [&](const std::vector<double>& values) {
    return fluid::last_periods(values, h.u_y, f.time_step);
  };
  verify_swing(f.name, "u_x", last(h.u_x), reference.u_x);
  verify_swing(f.name, "u_y", last(h.u_y), reference.u_y);
  verify_swing(f.name, "drag", last(h.drag), reference.drag);
  verify_swing(f.name, "lift", last(h.lift), reference.lift);
  verify_relative(f.name, "frequency", 1 / last(h.u_y).period, reference.frequency, 0.03);
}

#if DROGUE_FLAG == 1
void verify_steady(const std::string& level, const fluid::FlagSizes& sizes, int along, double tolerance) {
  const Flag f{"coupler/fsi1" + level,         0.2, 1000, 1.4e6, sizes, along, 0.5, 40, 2, "0", 0,
               "relative: 1e-3 absolute: 1e-8"};
  const History h = run(f);
  verify_relative(f.name, "u_x", h.u_x.back(), 2.270493e-5, tolerance);
  verify_relative(f.name, "u_y", h.u_y.back(), 8.208773e-4, tolerance);
  verify_relative(f.name, "drag", h.drag.back(), 14.29426, tolerance);
  verify_relative(f.name, "lift", h.lift.back(), 0.7637460, tolerance);
}

TEST(Flag, Fsi1) {
  verify_steady("_coarse", {0.005, 0.15, 0.04}, 24, 0.1);
  verify_steady("", {0.0025, 0.1, 0.025}, 36, 0.03);
}
#elif DROGUE_FLAG == 2
const SwingReference fsi2{{-14.85e-3, 12.70e-3, 0.03, 0.03},
                          {1.30e-3, 81.6e-3, 0.03, 0.03},
                          {215.06, 77.65, 0.03, 0.03},
                          {0.61, 237.8, 0.05, 0.05},
                          1.93};

Flag flag(const std::string& level, const fluid::FlagSizes& sizes, int along, double dt) {
  Flag f{
      "coupler/fsi2" + level, 1, 10000, 1.4e6, sizes, along, dt, 8, 0.5, "t < 0.5 ? 0 : (t < 0.8 ? 1.5 : 0)"};
  f.mirrored = true;
  return f;
}

TEST(Flag, Fsi2Coarse) {
  verify_swinging(flag("_coarse", {0.005, 0.15, 0.04}, 24, 0.01), fsi2);
}

TEST(Flag, Fsi2) {
  verify_swinging(flag("", {0.0035, 0.12, 0.026}, 36, 0.01), fsi2);
}

TEST(Flag, Fsi2HalfTheStep) {
  verify_swinging(flag("_half_the_step", {0.0035, 0.12, 0.026}, 36, 0.005), fsi2);
}
#else
const SwingReference fsi3{{-2.88e-3, 2.72e-3, 0.03, 0.03},
                          {1.47e-3, 34.99e-3, 0.03, 0.03},
                          {460.5, 27.74, 0.03, 0.03},
                          {2.50, 153.91, 0.05, 0.05},
                          5.46};

Flag flag(const std::string& level, const fluid::FlagSizes& sizes, int along, double dt) {
  Flag f{
      "coupler/fsi3" + level, 2, 1000, 5.6e6, sizes, along, dt, 2.4, 0.5, "t < 0.5 ? 0 : (t < 0.6 ? 40 : 0)"};
  f.mirrored = true;
  return f;
}

TEST(Flag, Fsi3Coarse) {
  verify_swinging(flag("_coarse", {0.005, 0.15, 0.04}, 24, 0.005), fsi3);
}

TEST(Flag, Fsi3) {
  verify_swinging(flag("", {0.0035, 0.12, 0.026}, 36, 0.005), fsi3);
}

TEST(Flag, Fsi3Fine) {
  verify_swinging(flag("_fine", {0.002, 0.1, 0.018}, 48, 0.005), fsi3);
}
#endif

} // namespace
} // namespace drogue::test
