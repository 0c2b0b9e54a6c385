// SPDX-License-Identifier: GPL-3.0-or-later
// A taut membrane over a layer of fluid, four processes, against the exact added mass.
//
// Membrane z = H, mass m_s an area, tension T, held at x = 0 and L; fluid below it, rigid floor at z = 0, p =
// 0 at x = 0 and L. Small amplitude: w = a sin(kx) cos(omega t), phi ~ sin(kx) cosh(kz), k = pi / L, and
//   omega^2 = T k^2 / (m_s + rho coth(kH) / k).
// The fluid's share of the mass is ten times the membrane's. In three dimensions, one cell wide, and in the
// plane, where y is up and a cable is the membrane.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

#include "common/io/state_file.hpp"
#include "common/mesh/msh.hpp"
#include "tests/mesh_mover/box_mesh.hpp"
#include "tests/support/checkpoint_runs.hpp"
#include "tests/support/verify.hpp"

namespace drogue::test {
namespace {

constexpr double L = 1, H = 0.5, width = 0.05, rho = 1, tension = 1, amplitude = 1e-3;
constexpr double k = std::numbers::pi / L;
constexpr int fluid_x = 28, fluid_z = 14,
              structure_x = 10; // not matching: 28 triangles' edges against 20 half elements

double added_mass() {
  return rho / (std::tanh(k * H) * k);
}
double structure_mass() {
  return added_mass() / 10;
}
double exact_omega() {
  return std::sqrt(tension * k * k / (structure_mass() + added_mass()));
}

/// A box one cell wide, whose cells grow thinner towards the membrane.
mesh::Mesh fluid_mesh() {
  std::vector<double> z = uniform(0, 1, fluid_z);
  for (double& s : z) s = H * (1.5 * s - 0.5 * s * s);
  return box_mesh({uniform(0, L, fluid_x), uniform(0, width, 1), z}, [](int, int, int) { return false; });
}

/// One row of nine-node quadrilaterals.
mesh::Mesh structure_mesh() {
  mesh::Mesh m;
  const int row = 2 * structure_x + 1;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < row; ++i) m.points.insert(m.points.end(), {L * i / (row - 1), width * j / 2, H});
  mesh::ElementBlock membrane{"membrane", mesh::ElementKind::quad9, {}};
  for (int e = 0; e < structure_x; ++e) {
    const std::int32_t a = 2 * e;
    membrane.nodes.insert(membrane.nodes.end(), {a, a + 2, a + 2 + 2 * row, a + 2 * row, a + 1, a + 2 + row,
                                                 a + 1 + 2 * row, a + row, a + 1 + row});
  }
  mesh::ElementBlock ends{"ends", mesh::ElementKind::point1, {}};
  for (int j = 0; j < 3; ++j) ends.nodes.insert(ends.nodes.end(), {j * row, j * row + row - 1});
  m.blocks = {membrane, ends};
  return m;
}

/// The plane layer, y up: triangles, edges with the fluid on their left.
mesh::Mesh plane_fluid_mesh() {
  mesh::Mesh m;
  constexpr int nx = fluid_x, ny = fluid_z;
  const auto id = [](int i, int j) { return j * (nx + 1) + i; };
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) {
      const double s = static_cast<double>(j) / ny;
      m.points.insert(m.points.end(), {L * i / nx, H * (1.5 * s - 0.5 * s * s), 0.0});
    }
  mesh::ElementBlock fluid{"fluid", mesh::ElementKind::tri3, {}};
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i)
      fluid.nodes.insert(fluid.nodes.end(), {id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j),
                                             id(i + 1, j + 1), id(i, j + 1)});
  mesh::ElementBlock floor{"floor", mesh::ElementKind::line2, {}}, top{"top", mesh::ElementKind::line2, {}},
      ends{"ends", mesh::ElementKind::line2, {}};
  for (int i = 0; i < nx; ++i) {
    floor.nodes.insert(floor.nodes.end(), {id(i, 0), id(i + 1, 0)});
    top.nodes.insert(top.nodes.end(), {id(i + 1, ny), id(i, ny)});
  }
  for (int j = 0; j < ny; ++j)
    ends.nodes.insert(ends.nodes.end(), {id(0, j + 1), id(0, j), id(nx, j), id(nx, j + 1)});
  m.blocks = {fluid, floor, top, ends};
  return m;
}

/// Two-node lines of half the length of the quadrilaterals above.
mesh::Mesh plane_structure_mesh() {
  mesh::Mesh m;
  constexpr int n = 2 * structure_x;
  mesh::ElementBlock membrane{"membrane", mesh::ElementKind::line2, {}};
  for (int i = 0; i <= n; ++i) m.points.insert(m.points.end(), {L * i / n, H, 0.0});
  for (int i = 0; i < n; ++i) membrane.nodes.insert(membrane.nodes.end(), {i, i + 1});
  m.blocks = {membrane, {"ends", mesh::ElementKind::point1, {0, n}}};
  return m;
}

/// Displaced along `up`: 1 in the plane, 2 in space.
void write_start(const std::filesystem::path& folder, const mesh::Mesh& structure, std::size_t up) {
  const auto n = static_cast<std::uint64_t>(structure.node_count());
  std::vector<double> d(3 * n, 0.0);
  for (std::size_t i = 0; i < n; ++i) d[3 * i + up] = amplitude * std::sin(k * structure.points[3 * i]);
  io::State state{"structure", mesh::hash(structure), 0, 0, {}};
  state.add("displacement", {n, 3}, d);
  state.add("velocity", {n, 3}, std::vector<double>(3 * n, 0.0));
  state.add("acceleration", {n, 3}, std::vector<double>(3 * n, 0.0));
  ASSERT_TRUE(io::write_state(folder / "start.state", state).ok());
}

void write_case(const std::filesystem::path& folder, const std::string& mesh_mover, double dt, int steps) {
  std::ofstream(folder / "case.textproto")
      << fmt::format("name: 'membrane on fluid' run_directory: 'run'\n"
                     "structure {{ command: 'structure_solver' config: 'structure.textproto' }}\n"
                     "mesh_mover {{ {} }}\n"
                     "fluid {{ command: 'fluid_solver' config: 'fluid.textproto' }}\n"
                     "time {{ step: {} steps: {} }}\n"
                     "loop {{ relative: 1e-4 }}\n"
                     "outer_boundary: FIXED\n",
                     mesh_mover, dt, steps);
}

/// In space. `mesh_mover`: which program moves the mesh, as in the case's own field.
void write_configs(const std::filesystem::path& folder, const std::string& mesh_mover, double dt, int steps) {
  std::ofstream(folder / "structure.textproto")
      << fmt::format("mesh: 'structure.msh' initial_state: 'start.state' interface: 'membrane'\n"
                     "membrane {{ group: 'membrane' thickness: 0.001 density: {} youngs_modulus: 10 "
                     "poisson_ratio: 0 prestress: {} }}\n"
                     "support {{ group: 'ends' components: 'z' }}\n"
                     "support {{ group: 'membrane' components: 'xy' }}\n"
                     "time {{ step: {} rho_infinity: 0.9 }}\n"
                     "newton {{ displacement_tolerance: 1e-12 }}\n"
                     "output {{ field_interval: 0 }}\n",
                     structure_mass() / 0.001, tension / 0.001, dt);
  std::ofstream(folder / "fluid.textproto")
      << fmt::format("mesh: 'fluid.msh' density: {} dynamic_viscosity: 1e-6\n"
                     "phase {{ formulation: DSD_SST step: {} }}\n"
                     "boundary {{ name: 'z1' no_slip {{ components: 'z' }} }}\n"
                     "boundary {{ name: 'z0' free_slip {{}} }}\n"
                     "boundary {{ name: 'y0' free_slip {{}} }}\n"
                     "boundary {{ name: 'y1' free_slip {{}} }}\n"
                     "boundary {{ name: 'x0' traction_free {{ backflow: 0 }} }}\n"
                     "boundary {{ name: 'x1' traction_free {{ backflow: 0 }} }}\n"
                     "interface: 'z1'\n"
                     "linear {{ tolerance: 1e-4 }}\n"
                     "output {{ field_interval: 0 }}\n",
                     rho, dt);
  std::ofstream(folder / "mesh.textproto") << "mesh: 'fluid.msh' tolerance: 1e-8\n"
                                              "boundary { name: 'z1' displacement {} }\n"
                                              "boundary { name: 'z0' fixed {} }\n"
                                              "boundary { name: 'y0' sliding { normal: 'y' } }\n"
                                              "boundary { name: 'y1' sliding { normal: 'y' } }\n"
                                              "boundary { name: 'x0' sliding { normal: 'x' } }\n"
                                              "boundary { name: 'x1' sliding { normal: 'x' } }\n"
                                              "interface: 'z1'\n"
                                              "output { field_interval: 0 }\n";
  write_case(folder, mesh_mover, dt, steps);
}

void write_plane_configs(const std::filesystem::path& folder, double dt) {
  std::ofstream(folder / "structure.textproto") << fmt::format(
      "mesh: 'structure.msh' initial_state: 'start.state' interface: 'membrane' plane: true\n"
      "truss {{ group: 'membrane' area: 0.001 density: {} youngs_modulus: 10 prestress: {} }}\n"
      "support {{ group: 'ends' components: 'y' }}\n"
      "support {{ group: 'membrane' components: 'x' }}\n"
      "time {{ step: {} rho_infinity: 0.9 }}\n"
      "newton {{ displacement_tolerance: 1e-12 }}\n"
      "output {{ field_interval: 0 }}\n",
      structure_mass() / 0.001, tension / 0.001, dt);
  std::ofstream(folder / "fluid.textproto")
      << fmt::format("mesh: 'fluid.msh' density: {} dynamic_viscosity: 1e-6\n"
                     "phase {{ formulation: DSD_SST step: {} }}\n"
                     "boundary {{ name: 'top' no_slip {{ components: 'y' }} }}\n"
                     "boundary {{ name: 'floor' free_slip {{}} }}\n"
                     "boundary {{ name: 'ends' traction_free {{ backflow: 0 }} }}\n"
                     "interface: 'top'\n"
                     "output {{ field_interval: 0 }}\n",
                     rho, dt);
  std::ofstream(folder / "mesh.textproto") << "mesh: 'fluid.msh' tolerance: 1e-8\n"
                                              "boundary { name: 'top' displacement {} }\n"
                                              "boundary { name: 'floor' fixed {} }\n"
                                              "boundary { name: 'ends' sliding { normal: 'x' } }\n"
                                              "interface: 'top'\n"
                                              "output { field_interval: 0 }\n";
}

/// Frequency of the least-squares fit a cos(omega t) + b sin(omega t) + c to equidistant samples.
double fitted_omega(const std::vector<double>& t, const std::vector<double>& w, double lower, double upper) {
  const auto misfit = [&](double omega) {
    Eigen::MatrixXd A(static_cast<Eigen::Index>(t.size()), 3);
    Eigen::VectorXd b(A.rows());
    for (Eigen::Index i = 0; i < A.rows(); ++i) {
      const auto s = static_cast<std::size_t>(i);
      A.row(i) << std::cos(omega * t[s]), std::sin(omega * t[s]), 1;
      b[i] = w[s];
    }
    return (A * A.colPivHouseholderQr().solve(b) - b).norm();
  };
  constexpr double golden = 0.6180339887498949;
  while (upper - lower > 1e-7 * upper) { // golden section
    const double a = upper - golden * (upper - lower), b = lower + golden * (upper - lower);
    (misfit(a) < misfit(b) ? upper : lower) = misfit(a) < misfit(b) ? b : a;
  }
  return 0.5 * (lower + upper);
}

double time_step() {
  return 2 * std::numbers::pi / exact_omega() / 48;
}

/// All files of the case.
void write_everything(const std::filesystem::path& folder, const std::string& mesh_mover, int steps) {
  const mesh::Mesh structure = structure_mesh();
  ASSERT_TRUE(mesh::write_msh(folder / "structure.msh", structure).ok());
  ASSERT_TRUE(mesh::write_msh(folder / "fluid.msh", fluid_mesh()).ok());
  write_start(folder, structure, 2);
  write_configs(folder, mesh_mover, time_step(), steps);
}

/// Runs the case and compares with the exact solution; `name` in the table of verifications, `up` the axis.
void verify_case(const std::filesystem::path& folder, const std::string& name, const std::string& up) {
  auto coupler =
      launcher::Process::start({{std::string(DROGUE_BIN_DIR) + "/coupler", "run", "case.textproto"},
                                {},
                                folder,
                                folder / "output.txt"});
  ASSERT_TRUE(coupler.ok());
  const auto& exit = coupler->wait(std::chrono::minutes(5));
  ASSERT_TRUE(exit.has_value() && exit->clean()) << read_text(folder / "output.txt");

  const Table drag = read_csv(folder / "run/drag.csv"), coupling = read_csv(folder / "run/coupling.csv");
  std::vector<double> t, w;
  for (std::size_t n = 0; n < drag.rows.size(); ++n) {
    t.push_back(drag.at(n, "time"));
    w.push_back(
        drag.at(n, "mean_displacement_" + up)); // 2/pi times the amplitude of the mode, from the start's
  }
  verify_relative(name, "omega", fitted_omega(t, w, 0.5 * exact_omega(), 2 * exact_omega()), exact_omega(),
                  0.03);
  // It comes down to the other side by nearly the same amplitude: the load has the right sign and size.
  const double lowest = *std::min_element(w.begin(), w.end());
  verify_relative(name, "swing", lowest, -2 * amplitude * 2 / std::numbers::pi, 0.05);
  double worst = 0;
  for (std::size_t i = 0; i < coupling.rows.size(); ++i)
    worst = std::max(worst, coupling.at(i, "force_defect"));
  verify(name, "force_defect", worst, 0, 1e-12);
}

void verify_with(const std::string& mesh_mover, const std::string& name) {
  const auto folder = fresh_folder("run");
  write_everything(folder, mesh_mover, 60);
  verify_case(folder, name, "z");
}

constexpr const char* our_mesh_mover = "command: 'mesh_mover' config: 'mesh.textproto'";

TEST(MembraneOnFluid, OscillatesWithTheExactAddedMass) {
  verify_with(our_mesh_mover, "coupler/membrane_on_fluid");
}

/// Lines on both sides of the interface, which do not match; a plane flow, a plane mesh motion, a plane
/// cable.
void write_plane_case(const std::filesystem::path& folder) {
  const mesh::Mesh structure = plane_structure_mesh();
  ASSERT_TRUE(mesh::write_msh(folder / "structure.msh", structure).ok());
  ASSERT_TRUE(mesh::write_msh(folder / "fluid.msh", plane_fluid_mesh()).ok());
  write_start(folder, structure, 1);
  write_plane_configs(folder, time_step());
  write_case(folder, our_mesh_mover, time_step(), 60);
}

/// With a limit on the mesh's distortion as small as the cable's motion the mesh is replaced again and again,
/// which must not change the motion.
TEST(MembraneOnFluid, APlaneCableOscillatesWithTheExactAddedMassOnNewMeshesToo) {
  const auto kept = fresh_folder("kept"), folder = fresh_folder("run");
  write_plane_case(kept);
  verify_case(kept, "coupler/cable_on_plane_fluid", "y");
  write_plane_case(folder);
  std::ofstream(folder / "mesh.textproto", std::ios::app) << "remesh { f_a: 2e-3 }\n";
  const std::string name = "coupler/cable_on_plane_fluid_remeshed";
  verify_case(folder, name, "y");
  const Table a = read_csv(kept / "run/drag.csv"), b = read_csv(folder / "run/drag.csv"),
              events = read_csv(folder / "run/remesh.csv");
  EXPECT_GE(events.rows.size(), 2u);
  ASSERT_EQ(a.rows.size(), b.rows.size());
  double motion = 0, mass = 0, momentum = 0;
  for (std::size_t n = 0; n < a.rows.size(); ++n)
    motion = std::max(motion, std::abs(a.at(n, "mean_displacement_y") - b.at(n, "mean_displacement_y")));
  for (std::size_t i = 0; i < events.rows.size(); ++i) {
    mass = std::max(mass, events.at(i, "mass_defect"));
    momentum = std::max(momentum, events.at(i, "momentum_defect"));
  }
  verify(name, "difference_from_the_first_mesh", motion / amplitude, 0, 5e-3);
  verify(name, "mass_defect", mass, 0, 1e-3);
  verify(name, "momentum_defect", momentum, 0, 1e-3);
}

// A structure in another language, examples/python_cable: the same elements and time integration, hence the
// same answer as ours to the tolerance of the coupling iteration.
TEST(MembraneOnFluid, APythonCableTakesThePlaceOfOurs) {
  const auto ours = fresh_folder("ours"), folder = fresh_folder("run");
  write_plane_case(ours);
  ASSERT_EQ(run_coupler_with(ours, {"run", "case.textproto"}), 0) << read_text(ours / "output.txt");
  write_plane_case(folder);
  std::string text = read_text(folder / "case.textproto");
  const std::string before = "command: 'structure_solver' config: 'structure.textproto'";
  std::string python = "command: '" DROGUE_SOURCE_DIR "/examples/python_cable/cable.py' "
                       "environment: 'PYTHONPATH=" DROGUE_PYTHON_DIR "'";
  for (const std::string& argument :
       {std::string("--from"), std::string("0"), fmt::format("{}", H), std::string("--to"),
        fmt::format("{}", L), fmt::format("{}", H), std::string("--elements"),
        fmt::format("{}", 2 * structure_x), std::string("--line-density"),
        fmt::format("{}", structure_mass()), std::string("--tension"), fmt::format("{}", tension),
        std::string("--stiffness"), std::string("0.01"), std::string("--free"), std::string("y"),
        std::string("--start"), fmt::format("{}", amplitude)})
    python += fmt::format(" argument: '{}'", argument);
  text.replace(text.find(before), before.size(), python);
  std::ofstream(folder / "case.textproto") << text;
  const std::string name = "coupler/cable_on_plane_fluid_python";
  verify_case(folder, name, "y");
  const Table a = read_csv(ours / "run/drag.csv"), b = read_csv(folder / "run/drag.csv");
  ASSERT_EQ(a.rows.size(), b.rows.size());
  double worst = 0;
  for (std::size_t n = 0; n < a.rows.size(); ++n)
    worst = std::max(worst, std::abs(a.at(n, "mean_displacement_y") - b.at(n, "mean_displacement_y")));
  verify(name, "difference_from_ours", worst / amplitude, 0, 1e-3);
}

/// The case with fields and probes every second step, and a checkpoint every two.
std::filesystem::path case_with_checkpoints(const std::string& name, int steps) {
  const auto folder = fresh_folder(name);
  write_everything(folder, our_mesh_mover, steps);
  for (const char* config : {"structure.textproto", "fluid.textproto", "mesh.textproto"}) {
    std::string text = read_text(folder / config);
    text.replace(text.find("field_interval: 0"), 17, "field_interval: 2");
    if (config[0] != 'm') text += "probe { name: 'middle' x: 0.5 y: 0.025 z: 0.5 }\n";
    std::ofstream(folder / config) << text;
  }
  std::ofstream(folder / "case.textproto", std::ios::app) << "checkpoints { steps: 2 }\n";
  return folder;
}

// Our own solvers, stopped by a signal in the middle of a step and resumed: the same results and states to
// the bit, in series that go on as if nothing had happened.
TEST(MembraneOnFluid, AResumedRunIsTheUndisturbedOneToTheBit) {
  const auto whole = case_with_checkpoints("whole", 6), folder = case_with_checkpoints("resumed", 6);
  ASSERT_EQ(run_coupler_with(whole, {"run", "case.textproto"}), 0) << read_text(whole / "output.txt");
  launcher::Process coupler = start_program(folder, {"run", "case.textproto"});
  const auto output = [&] { return read_text(folder / "output.txt"); };
  ASSERT_TRUE(eventually([&] { return output().find("step 3/6") != std::string::npos; }, 120)) << output();
  kill(coupler.pid(), SIGTERM);
  const auto exit = coupler.wait(std::chrono::minutes(1));
  ASSERT_TRUE(exit.has_value());
  EXPECT_EQ(exit->status, 5) << output();
  ASSERT_EQ(run_coupler_with(folder, {"resume", "run"}), 0) << output();
  const auto expected = everything(whole, 6);
  for (const char* file : {"structure/structure.pvd", "structure/structure_000006.vtu",
                           "structure/probes.csv", "fluid/fluid.pvd", "fluid/probes.csv", "fluid/forces.csv",
                           "mesh_mover/mesh.pvd", "checkpoints/00000006/fluid/fluid.state"})
    EXPECT_TRUE(expected.count(file)) << file;
  expect_same(expected, everything(folder, 6));
}

// A program in another language takes the place of ours: the example of examples/python_mesh_mover.
TEST(MembraneOnFluid, APythonMeshMoverTakesThePlaceOfOurs) {
  verify_with("command: '" DROGUE_SOURCE_DIR "/examples/python_mesh_mover/mesh_mover.py' "
              "argument: '--mesh' argument: '${config_dir}/fluid.msh' argument: '--interface' argument: 'z1' "
              "environment: 'PYTHONPATH=" DROGUE_PYTHON_DIR "'",
              "coupler/membrane_on_fluid_python");
}

} // namespace
} // namespace drogue::test
