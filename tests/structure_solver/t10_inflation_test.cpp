// SPDX-License-Identifier: GPL-3.0-or-later
//
// The T-10 of [stein2001] inflated from its flat pattern, as configs/t10/quick does it: counts of the paper,
// shape, and the balance of forces. The shape's references come from an independent program on a mesh of the
// same subdivision whose lines meet the confluence points half a gore further round; its loads and lengths
// agree within the tolerances.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <unistd.h>

#include <gtest/gtest.h>

#include "parachute_mesher/commands.hpp"
#include "structure_solver/fields.hpp"
#include "structure_solver/run.hpp"
#include "structure_solver/state_io.hpp"
#include "tests/support/verify.hpp"

namespace drogue::structure {
namespace {

namespace fs = std::filesystem;

/// p times the canopy's projected area: the vertical pressure force on the current surface.
double vertical_pressure_force(const Model& model, const State& state, double pressure) {
  double area = 0;
  for (const mesh::ElementBlock* block : model.mesh.blocks_of("canopy"))
    for (std::int32_t e = 0; e < block->count(); ++e)
      for (const auto& point : element_rule<mesh::ElementKind::quad9>().points) {
        Eigen::Matrix<double, 3, 9> x;
        for (int a = 0; a < 9; ++a)
          for (int c = 0; c < 3; ++c) {
            const std::size_t i =
                3 * static_cast<std::size_t>(block->element(e)[static_cast<std::size_t>(a)]) +
                static_cast<std::size_t>(c);
            x(c, a) = model.mesh.points[i] + state.u[i];
          }
        const Eigen::Matrix<double, 3, 2> g = x * point.dN;
        area += g.col(0).cross(g.col(1))(2) * point.weight;
      }
  return pressure * area;
}

/// The config with another pressure: the paper's in place of the quick case's.
void write_with_pressure(const fs::path& from, const std::string& old, const std::string& pressure,
                         const fs::path& to) {
  std::ostringstream text;
  text << std::ifstream(from).rdbuf();
  std::string config = text.str();
  const std::string quoted = '"' + old + '"';
  const std::size_t at = config.find(quoted);
  ASSERT_NE(at, std::string::npos) << from << " holds no " << quoted;
  config.replace(at, quoted.size(), '"' + pressure + '"');
  std::ofstream(to) << config;
}

TEST(T10, InflationFromTheFlatPattern) {
  const fs::path previous = fs::current_path();
  const fs::path folder = fs::temp_directory_path() / ("drogue-t10-inflation-" + std::to_string(getpid()));
  fs::create_directories(folder);
  const fs::path quick = fs::path(DROGUE_SOURCE_DIR) / "configs/t10/quick";
  fs::copy_file(quick / "parachute.textproto", folder / "parachute.textproto");
  write_with_pressure(quick / "inflation.textproto", "0.9", "0.5", folder / "inflation.textproto");
  fs::current_path(folder);
  const auto meshed = parachute::write_structure_mesh("parachute.textproto");
  ASSERT_TRUE(meshed) << meshed.error().message;
  const auto c = load_case("inflation.textproto");
  ASSERT_TRUE(c) << c.error().message;
  const auto done = run(*c);
  ASSERT_TRUE(done) << done.error().message;
  const auto state = read_state("inflated.state", *c->model);
  ASSERT_TRUE(state) << state.error().message;
  fs::current_path(previous);
  fs::remove_all(folder);

  using drogue::test::verify;
  using drogue::test::verify_relative;
  const Model& model = *c->model;
  double held = 0, radius = 0;
  for (const std::uint8_t h : model.held) held += h;
  for (const std::int32_t node : model.mesh.nodes_of("canopy")) {
    const std::size_t i = 3 * static_cast<std::size_t>(node);
    radius = std::max(
        radius, std::hypot(model.mesh.points[i] + state->u[i], model.mesh.points[i + 1] + state->u[i + 1]));
  }
  const StressFields stress = stress_fields(model, state->u, state->time);
  Integrator integrator(model, c->integrator_options(), *state);
  const double line_force = -integrator.balance().reactions[0][2];

  verify("t10/inflation", "equations", static_cast<double>(model.equation_count()) - held, 10713, 0);
  verify("t10/inflation", "unbalance", integrator.balance().unbalance, 0, 2.5e-3);
  verify_relative("t10/inflation", "line_force_over_pressure_force", line_force,
                  vertical_pressure_force(model, *state, 0.5), 3e-3);
  verify_relative("t10/inflation", "diameter_mid_gore", 2 * radius, 29.17, 5e-3);
  verify_relative("t10/inflation", "line_force", line_force, 282.84, 5e-3);
  verify_relative("t10/inflation", "largest_cable_tension", stress.max_tension, 10.84, 0.05);
  verify_relative("t10/inflation", "largest_principal_stress", stress.max_stress, 37060, 0.07);
  verify_relative("t10/inflation", "smallest_principal_stress", stress.min_stress, -5920, 0.05);
  verify("t10/inflation", "slack_fraction", stress.slack_fraction, 0, 0);
}

} // namespace
} // namespace drogue::structure
