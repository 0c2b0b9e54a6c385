// SPDX-License-Identifier: GPL-3.0-or-later
//
// The tests of [stein2003] in two dimensions: a plate without thickness, thin elements along it, in a square.
// It is translated by half its length, turned by 45 degrees and bent to half a circle, in ten steps, with
// stiffening exponents from 0 to 2. Measured: f_A and f_AR over the whole mesh, and over the thin elements
// beside the plate.
#include <numbers>

#include "tests/mesh_mover/mover_cases.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/mesh_domains.hpp"

namespace drogue::mesh_mover {
namespace {

using drogue::test::verify;
using drogue::test::verify_between;

constexpr int steps = 10;
const std::vector<double> exponents = {0, 1, 1.5, 2};

/// Displacement of the plate's points (x, 0); t goes from 0 to 1.
struct PlateMotion {
  std::string name, x, y;
};
const PlateMotion translation = {"translation", "0", "0.5*t"};
const PlateMotion rotation = {"rotation", "x*(cos(pi/4*t) - 1)", "x*sin(pi/4*t)"};
const PlateMotion bending = {"bending", "sin(pi*t*x)/(pi*t) - x", "2*sin(pi*t*x/2)^2/(pi*t)"};

struct Distortion {
  double f_A = 0, f_AR = 0;
};

/// f_A and f_AR of the elements of one group.
Distortion distortion(const MeshMover& mover, const std::string& group) {
  Distortion d;
  for (const auto* block : mover.mesh().blocks_of(group))
    for (std::int32_t e = 0; e < block->count(); ++e) {
      const CellShape now = cell_shape(2, mover.points(), block->element(e));
      const CellShape before = cell_shape(2, mover.mesh().points, block->element(e));
      d.f_A = std::max(d.f_A, std::abs(std::log2(now.jacobian / before.jacobian)));
      d.f_AR = std::max(d.f_AR, std::abs(std::log2(now.aspect / before.aspect)));
    }
  return d;
}

struct Outcome {
  Quality quality;
  Distortion layer;
  bool is_inverted = false;
};

Settings settings_for(const PlateMotion& motion, double chi) {
  Settings settings;
  settings.boundaries = {boundary("outer", Condition::fixed), moved("plate", motion.x, motion.y)};
  settings.stiffening_exponent = chi;
  settings.stop.min_volume_ratio = 0;
  return settings;
}

/// After all steps, or at the first inverted element.
Outcome move(const Settings& settings) {
  const auto mover = make(test::plate_in_square(), settings);
  Outcome outcome;
  for (int step = 1; step <= steps; ++step) {
    EXPECT_TRUE(mover->begin_step(1.0 / steps).ok());
    const auto report = solve_at(*mover, static_cast<double>(step) / steps);
    if (!report) {
      outcome.is_inverted = true;
      return outcome;
    }
    outcome.quality = report->quality;
    mover->commit();
  }
  outcome.layer = distortion(*mover, "layer");
  return outcome;
}

/// Without stiffening the thin elements are lost. With it none is inverted, the whole mesh stays within `f_A`
/// and `f_AR`, and the more stiffening, the less the thin elements change.
void verify_table(const PlateMotion& motion, double f_A, double f_AR) {
  std::vector<double> layers;
  for (const double chi : exponents) {
    const Outcome row = move(settings_for(motion, chi));
    const std::string name = fmt::format("mesh/plate_{}_chi{:g}", motion.name, chi);
    verify(name, "inversion", row.is_inverted, chi == 0, 0);
    if (chi == 0) continue;
    verify_between(name, "f_A", row.quality.f_A, 0, f_A);
    verify_between(name, "f_AR", row.quality.f_AR, 0, f_AR);
    verify_between(name, "f_A_of_thin_elements", row.layer.f_A, 0, layers.empty() ? f_A : layers.back());
    verify_between(name, "f_AR_of_thin_elements", row.layer.f_AR, 0, f_AR);
    layers.push_back(0.7 * row.layer.f_A); // the next exponent's bound
  }
}

TEST(Plate, Translation) {
  verify_table(translation, 3, 3);
}

TEST(Plate, Rotation) {
  verify_table(rotation, 2, 4.5);
}

TEST(Plate, Bending) {
  verify_table(bending, 2, 4.5);
}

/// The algebraic method carries rigid motions of the plate into the mesh around it.
TEST(Plate, AlgebraicMethod) {
  for (const auto& motion : {translation, rotation}) {
    Settings settings = settings_for(motion, 0);
    settings.method = Method::algebraic;
    const Outcome row = move(settings);
    const std::string name = fmt::format("mesh/plate_{}_algebraic", motion.name);
    verify(name, "inversion", row.is_inverted, 0, 0);
    verify_between(name, "f_A", row.quality.f_A, 0, 3);
    verify_between(name, "f_AR", row.quality.f_AR, 0, 4.5);
    verify_between(name, "f_A_of_thin_elements", row.layer.f_A, 0, 0.1);
    verify_between(name, "f_AR_of_thin_elements", row.layer.f_AR, 0, 0.1);
  }
}

/// f_A after the plate was bent and unbent.
double f_A_after_cycle(Increment increment) {
  Settings settings = settings_for(bending, 1.5);
  settings.increment = increment;
  settings.max_sub_increments = 16;
  const auto mover = make(test::plate_in_square(), settings);
  double f_A = 0;
  for (int step = 1; step < 2 * steps; ++step)
    f_A = step_to(*mover, 1e-9 + 1 - std::abs(1 - static_cast<double>(step) / steps)).quality.f_A;
  f_A = step_to(*mover, 1e-12).quality.f_A; // at zero the expressions divide by zero
  return f_A;
}

TEST(Plate, ReturnsAfterAClosedCycle) {
  verify("mesh/plate_cycle_from_initial", "f_A", f_A_after_cycle(Increment::from_initial), 0, 1e-6);
  verify_between("mesh/plate_cycle_from_last_step", "f_A", f_A_after_cycle(Increment::from_last_step), 1e-3,
                 1);
}

} // namespace
} // namespace drogue::mesh_mover
