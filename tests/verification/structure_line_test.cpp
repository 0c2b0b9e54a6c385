// SPDX-License-Identifier: GPL-3.0-or-later
//
// Cables against exact solutions: the elastic catenary [irvine1981] under refinement, a taut cable under a
// point load, and the natural frequencies of a taut string and a hanging chain.
#include <gtest/gtest.h>

#include "tests/support/verify.hpp"
#include "tests/verification/structure_shapes.hpp"

namespace drogue::structure {
namespace {

using drogue::test::verify_between;
using drogue::test::verify_relative;

struct Catenary {
  double sag, tension;
};

/// S = 10, EA = 2e4, W = 10, L0 = 10.25, both ends at one height.
Catenary catenary(int elements) {
  Settings s;
  s.cables = {{"line", {1.0, 10.0 / 10.25, 2e4, 0, StrainMeasure::engineering, true}, 10.25 / elements}};
  s.supports = {{"first", {true, true, true}, {}}, {"last", {true, true, true}, {}}};
  s.ignored_groups = {"middle"};
  s.gravity = test::vector("0", "0", "-1");
  const Model model = test::model(s, test::chain(elements, {0, 0, 0}, {10, 0, 0}));
  State start = rest_state(model);
  for (std::size_t i = 0; i < model.node_count(); ++i) { // near a parabola of the cable's length
    const double x = model.mesh.points[3 * i];
    start.u[3 * i + 2] = -0.04 * x * (10 - x);
  }
  Integrator integrator(model, {0.0, 5.0, {.displacement_tolerance = 1e-10, .max_iterations = 100}}, start);
  test::settle(integrator, 0.1, 80);
  test::settle(integrator, 10.0, 20);
  const Balance b = integrator.balance();
  EXPECT_LT(b.unbalance, 1e-6);
  const auto middle = static_cast<std::size_t>(elements / 2);
  return {-integrator.committed().u[3 * middle + 2], -b.reactions[0][0]};
}

TEST(Cable, CatenaryUnderRefinement) {
  const double sag = 0.98963217, tension = 12.4726810;
  const Catenary coarse = catenary(20), fine = catenary(40);
  verify_relative("structure/catenary_40", "sag", fine.sag, sag, 1e-3);
  verify_relative("structure/catenary_40", "horizontal_tension", fine.tension, tension, 1e-3);
  const double sag_order = std::log2((coarse.sag - sag) / (fine.sag - sag));
  const double tension_order = std::log2((coarse.tension - tension) / (fine.tension - tension));
  verify_between("structure/catenary_40", "sag_order", sag_order, 1.9, 2.1);
  verify_between("structure/catenary_40", "tension_order", tension_order, 1.9, 2.1);
}

/// Taut cable, S = 10, EA = 1e4, initial tension 10, P = 5 in the middle: sag 0.35542136, T = 35.258268.
TEST(Cable, TautCableUnderAPointLoad) {
  const int n = 10;
  const double natural = 10 / (1 + 10 / 1e4) / n;
  Settings s;
  s.cables = {{"line", {1.0, 1e-3, 1e4, 0, StrainMeasure::engineering, true}, natural}};
  s.supports = {{"first", {true, true, true}, {}}, {"last", {true, true, true}, {}}};
  s.forces = {{"middle", test::vector("0", "0", "-5")}};
  const Model model = test::model(s, test::chain(n, {0, 0, 0}, {10, 0, 0}));
  Integrator integrator(model, {0.0, 10.0, {.displacement_tolerance = 1e-10, .max_iterations = 50}},
                        rest_state(model));
  test::settle(integrator, 0.5, 60);
  const State& state = integrator.committed();
  verify_relative("structure/taut_cable", "sag", -state.u[3 * (n / 2) + 2], 0.35542136, 1e-4);
  const auto& batch = std::get<Batch<Line>>(model.batches[0]);
  Line::Positions x;
  for (int a = 0; a < 2; ++a)
    for (int c = 0; c < 3; ++c)
      x(c, a) = model.mesh.points[static_cast<std::size_t>(3 * a + c)] +
                state.u[static_cast<std::size_t>(3 * a + c)];
  verify_relative("structure/taut_cable", "tension", Line::tension(batch.reference[0], batch.material, x),
                  35.258268, 1e-4);
}

/// f_n = n / (2 L) sqrt(T / (rho A)), L^2 rho A = 0.392028 kg m.
TEST(Cable, FrequenciesOfATautString) {
  for (const double tension : {6171.050, 12345.295}) {
    Settings s;
    s.cables = {{"line", {1e-4, 3920.28, 1e12, tension / 1e-4, StrainMeasure::green, true}, {}}};
    s.supports = {{"first", {true, true, true}, {}}, {"last", {true, true, true}, {}}};
    s.ignored_groups = {"middle"};
    const Model model = test::model(s, test::chain(40, {0, 0, 0}, {1, 0, 0}));
    const auto omega = test::frequencies(model, rest_state(model).u, 6); // two directions each
    const double exact = 0.5 * std::sqrt(tension / 0.392028);
    const std::string name = tension < 1e4 ? "structure/string_6171N" : "structure/string_12345N";
    for (std::size_t n = 1; n <= 3; ++n)
      verify_relative(name, "f_" + std::to_string(n), omega[2 * n - 2] / (2 * std::numbers::pi),
                      static_cast<double>(n) * exact, 5e-3);
  }
}

/// omega_n = j_{0,n} / 2 sqrt(g / L)
TEST(Cable, FrequenciesOfAHangingChain) {
  Settings s;
  s.cables = {{"line", {1e-4, 1e4, 1e11, 0, StrainMeasure::green, true}, {}}};
  s.supports = {{"first", {true, true, true}, {}}};
  s.ignored_groups = {"middle", "last"};
  s.gravity = test::vector("0", "0", "-9.81");
  const Model model = test::model(s, test::chain(80, {0, 0, 0}, {0, 0, -3}));
  Integrator integrator(model, {0.0, 1.0, {.displacement_tolerance = 1e-14, .max_iterations = 50}},
                        rest_state(model));
  test::settle(integrator, 10.0, 10);
  const auto omega = test::frequencies(model, integrator.committed().u, 6);
  const double unit = std::sqrt(9.81 / 3);
  const std::array<double, 3> exact = {1.20241, 2.76004, 4.32686};
  for (std::size_t n = 0; n < 3; ++n)
    verify_relative("structure/hanging_chain", "omega_" + std::to_string(n + 1), omega[2 * n],
                    exact[n] * unit, 5e-3);
}

} // namespace
} // namespace drogue::structure
