// SPDX-License-Identifier: GPL-3.0-or-later
// The examples in C and C++, built against the installed package, in the place of Drogue's own programs: a
// fluid that only radiates, p = -rho c v.n, damps what it wets by its impedance an area,
//   m a + rho c v + k d = 0,
// to the bit of the coupling's tolerance for the example's spring, and a membrane under tension T oscillates
// as
//   w = sin(pi x / L) exp(-g t) cos(omega t),  g = rho c / (2 m),  omega^2 = T (pi / L)^2 / m - g^2.
#include <cmath>
#include <cstdlib>
#include <numbers>

#include <Eigen/Dense>

#include "common/io/state_file.hpp"
#include "common/mesh/msh.hpp"
#include "tests/support/checkpoint_runs.hpp"
#include "tests/support/verify.hpp"

namespace drogue::test {
namespace {

namespace fs = std::filesystem;
constexpr const char* piston = DROGUE_EXAMPLES_DIR "/c_piston_fluid/piston_fluid";
constexpr const char* spring = DROGUE_EXAMPLES_DIR "/cpp_spring/spring";

/// A participant of a case: program and arguments.
std::string participant(const std::string& role, const std::string& command) {
  std::istringstream words(command);
  std::string text, word;
  words >> word;
  text = fmt::format("{} {{ command: '{}'", role, word);
  while (words >> word) text += fmt::format(" argument: '{}'", word);
  return text + " }\n";
}

struct Wall {
  double impedance, size_x, size_y, height;
  int cells_x, cells_y;
  double pressure = 0; ///< of the fluid at rest
  [[nodiscard]] std::string arguments() const {
    return fmt::format(" --size {} {} --cells {} {} --height {}", size_x, size_y, cells_x, cells_y, height);
  }
  [[nodiscard]] std::string participants() const {
    return participant("fluid",
                       fmt::format("{} fluid --impedance {} --pressure {}", piston, impedance, pressure) +
                           arguments()) +
           participant("mesh_mover", std::string(piston) + " mesh_mover" + arguments());
  }
};

void write_case(const fs::path& folder, const std::string& participants, double dt, int steps,
                const std::string& loop = "relative: 1e-9") {
  std::ofstream(folder / "case.textproto")
      << "name: 'piston' run_directory: 'run'\n"
      << participants
      << fmt::format("time {{ step: {} steps: {} }}\nloop {{ {} }}\nouter_boundary: FIXED\n", dt, steps,
                     loop);
}

Table run_case(const fs::path& folder) {
  EXPECT_EQ(run_coupler_with(folder, {"run", "case.textproto"}), 0) << read_text(folder / "output.txt");
  return read_csv(folder / "run/drag.csv");
}

/// `structure`: the command, with places for mass, stiffness and start.
void verify_spring(const std::string& name, const std::string& structure) {
  constexpr double m = 0.5, k = 40, rho_c = 3, start = 0.01, dt = 0.01;
  constexpr int steps = 60;
  const auto folder = fresh_folder("spring");
  write_case(folder,
             participant("structure", fmt::format(fmt::runtime(structure), m, k, start)) +
                 Wall{rho_c, 1, 1, 0, 5, 3}.participants(),
             dt, steps);
  const Table drag = run_case(folder);
  ASSERT_EQ(drag.rows.size(), static_cast<std::size_t>(steps));
  // The trapezoidal rule for both together.
  double d = start, v = 0, a = -k / m * start, worst = 0;
  for (int n = 0; n < steps; ++n) {
    const double d_guess = d + dt * v + 0.25 * dt * dt * a, v_guess = v + 0.5 * dt * a;
    a = -(k * d_guess + rho_c * v_guess) / (m + 0.5 * dt * rho_c + 0.25 * dt * dt * k);
    d = d_guess + 0.25 * dt * dt * a;
    v = v_guess + 0.5 * dt * a;
    worst =
        std::max(worst, std::abs(drag.at(static_cast<std::size_t>(n), "mean_displacement_z") - (d - start)));
  }
  verify(name, "difference_from_both_as_one", worst / start, 0, 1e-8);
}

TEST(PistonFluid, DampsTheSpringByItsImpedance) {
  verify_spring("coupler/piston_spring", std::string(spring) + " --mass {} --stiffness {} --start {}");
}

TEST(PistonFluid, DampsTheSpringInFortranByItsImpedance) {
  const std::string program = DROGUE_EXAMPLES_DIR "/fortran_spring/spring";
  if (!fs::exists(program)) GTEST_SKIP() << "gfortran is not installed";
  verify_spring("coupler/piston_spring_fortran", program + " {} {} {}");
}

constexpr double L = 1, width = 0.05, tension = 1, mass = 0.1, rho_c = 0.2, amplitude = 1e-3;
constexpr int elements = 10;

/// One row of nine-node quadrilaterals in the plane z = 0.
mesh::Mesh membrane() {
  mesh::Mesh m;
  constexpr int row = 2 * elements + 1;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < row; ++i) m.points.insert(m.points.end(), {L * i / (row - 1), width * j / 2, 0});
  mesh::ElementBlock block{"membrane", mesh::ElementKind::quad9, {}},
      ends{"ends", mesh::ElementKind::point1, {}};
  for (int e = 0; e < elements; ++e) {
    const std::int32_t a = 2 * e;
    block.nodes.insert(block.nodes.end(), {a, a + 2, a + 2 + 2 * row, a + 2 * row, a + 1, a + 2 + row,
                                           a + 1 + 2 * row, a + row, a + 1 + row});
  }
  for (int j = 0; j < 3; ++j) ends.nodes.insert(ends.nodes.end(), {j * row, j * row + row - 1});
  m.blocks = {block, ends};
  return m;
}

void write_membrane(const fs::path& folder, double dt) {
  const mesh::Mesh m = membrane();
  ASSERT_TRUE(mesh::write_msh(folder / "structure.msh", m).ok());
  const auto n = static_cast<std::uint64_t>(m.node_count());
  std::vector<double> d(3 * n, 0.0);
  for (std::size_t i = 0; i < n; ++i)
    d[3 * i + 2] = amplitude * std::sin(std::numbers::pi * m.points[3 * i] / L);
  io::State state{"structure", mesh::hash(m), 0, 0, {}};
  state.add("displacement", {n, 3}, d);
  state.add("velocity", {n, 3}, std::vector<double>(3 * n, 0.0));
  state.add("acceleration", {n, 3}, std::vector<double>(3 * n, 0.0));
  ASSERT_TRUE(io::write_state(folder / "start.state", state).ok());
  std::ofstream(folder / "structure.textproto")
      << fmt::format("mesh: 'structure.msh' initial_state: 'start.state' interface: 'membrane'\n"
                     "membrane {{ group: 'membrane' thickness: 0.001 density: {} youngs_modulus: 10 "
                     "poisson_ratio: 0 prestress: {} }}\n"
                     "support {{ group: 'ends' components: 'z' }}\n"
                     "support {{ group: 'membrane' components: 'xy' }}\n"
                     "time {{ step: {} rho_infinity: 1 }}\n"
                     "newton {{ displacement_tolerance: 1e-13 }}\n"
                     "output {{ field_interval: 0 }}\n",
                     mass / 0.001, tension / 0.001, dt);
}

struct Decay {
  double omega, rate;
};
/// Of x_n ~ exp(-rate n dt) cos(omega n dt + phase), from the least squares of x_{n+2} + a x_{n+1} + b x_n =
/// 0.
Decay fitted(const std::vector<double>& x, double dt) {
  Eigen::MatrixXd A(static_cast<Eigen::Index>(x.size()) - 2, 2);
  Eigen::VectorXd rhs(A.rows());
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const auto n = static_cast<std::size_t>(i);
    A.row(i) << x[n + 1], x[n];
    rhs[i] = -x[n + 2];
  }
  const Eigen::Vector2d s = A.colPivHouseholderQr().solve(rhs); // roots r: r^2 + s0 r + s1 = 0, |r|^2 = s1
  return {std::acos(-0.5 * s[0] / std::sqrt(s[1])) / dt, -0.5 * std::log(s[1]) / dt};
}

TEST(PistonFluid, DampsAMembraneByItsImpedance) {
  const double rate = rho_c / (2 * mass);
  const double omega = std::sqrt(tension / mass * std::pow(std::numbers::pi / L, 2) - rate * rate);
  const double dt = 2 * std::numbers::pi / omega / 80;
  const auto folder = fresh_folder("membrane");
  write_membrane(folder, dt);
  write_case(folder,
             "structure { command: 'structure_solver' config: 'structure.textproto' }\n" +
                 Wall{rho_c, L, width, 0, 28, 1}.participants(),
             dt, 120);
  const Table drag = run_case(folder);
  std::vector<double> x;
  for (std::size_t n = 0; n < drag.rows.size(); ++n) // the mean of the mode is 2/pi of its amplitude
    x.push_back(drag.at(n, "mean_displacement_z") + 2 / std::numbers::pi * amplitude);
  const Decay found = fitted(x, dt);
  verify_relative("coupler/membrane_on_piston", "omega", found.omega, omega, 0.005);
  verify_relative("coupler/membrane_on_piston", "decay_rate", found.rate, rate, 0.01);
}

// CalculiX, driven by the adapter of examples/python_calculix, as the structure: an elastic bar of length l,
// held at one end, whose other end is wetted by a fluid of the bar's own impedance, rho c = sqrt(E rho_s).
// The pressure p of the fluid sets in at t = 0; the bar's wave comes back from the held end and passes into
// the fluid without reflection:
//   u = p t / (2 rho c) until 2 l / c, and p l / E from then on.
TEST(PistonFluid, MatchesTheBarOfCalculix) {
  if (std::system("command -v ccx > /dev/null") != 0)
    GTEST_SKIP() << "CalculiX is not installed (calculix-ccx)";
  constexpr double l = 1, young = 100, density = 1, side = 0.2, p = 1,
                   dt = 0.01; // examples/python_calculix/bar.inp
  const double impedance = std::sqrt(young * density);
  const auto folder = fresh_folder("bar");
  std::string structure =
      participant("structure", DROGUE_SOURCE_DIR
                  "/examples/python_calculix/calculix_structure.py --deck " DROGUE_SOURCE_DIR
                  "/examples/python_calculix/bar.inp --surface WET");
  structure.replace(structure.find(" }"), 2, " environment: 'PYTHONPATH=" DROGUE_PYTHON_DIR "' }");
  Wall wall{impedance, side, side, 0, 3, 2};
  wall.pressure = p;
  write_case(folder, structure + wall.participants(), dt, 30, "relative: 1e-5 absolute: 1e-8");
  const Table drag = run_case(folder);
  ASSERT_EQ(drag.rows.size(), 30U);
  const auto u = [&](int step) { return drag.at(static_cast<std::size_t>(step) - 1, "mean_displacement_z"); };
  const std::string name = "coupler/calculix_bar_on_piston";
  verify_relative(name, "velocity", (u(16) - u(6)) / (10 * dt), p / (2 * impedance), 0.02);
  verify_relative(name, "displacement_at_half_time", u(10), 0.5 * p * l / young, 0.05);
  verify_relative(name, "displacement_at_the_end", u(30), p * l / young, 0.03);
}

} // namespace
} // namespace drogue::test
