// SPDX-License-Identifier: GPL-3.0-or-later
// The cavity with a flexible bottom, until the lid slows down, with a structure in another language in place
// of ours: examples/python_cable has the same elements, masses and time integration, hence the same answer to
// the tolerance of the coupling iteration.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/verify.hpp"
#include "tests/verification/coupled_run.hpp"
#include "tests/verification/flexible_cavity.hpp"

namespace drogue::test {
namespace {

constexpr double end = 3.5; ///< past the fastest lid

/// The same membrane: E h = 0.5, rho_s h = 1 a width of one, no prestress.
std::string python_structure(int elements) {
  return fmt::format(
      "command: '{}/examples/python_cable/cable.py' environment: 'PYTHONPATH={}' "
      "argument: '--from' argument: '0' argument: '0' argument: '--to' argument: '1' argument: '0' "
      "argument: '--elements' argument: '{}' argument: '--line-density' argument: '1' "
      "argument: '--tension' argument: '0' argument: '--stiffness' argument: '0.5'",
      DROGUE_SOURCE_DIR, DROGUE_PYTHON_DIR, elements);
}

CoupledRun run(const std::string& name, const Cavity& c) {
  const auto folder = fresh_folder(name);
  write_case(folder, c);
  return run_coupled(folder, std::chrono::minutes(6));
}

TEST(FlexibleCavity, APythonStructureTakesThePlaceOfOurs) {
  Cavity c;
  c.cells = 16;
  c.end = end;
  const CoupledRun ours = run("ours", c);
  c.structure = python_structure(c.cells);
  const CoupledRun python = run("python", c);

  const std::vector<double> a = column(ours.steps, "mean_displacement_y"),
                            b = column(python.steps, "mean_displacement_y");
  ASSERT_EQ(a.size(), static_cast<std::size_t>(std::lround(c.end / c.time_step)));
  ASSERT_EQ(a.size(), b.size());
  double largest = 0, difference = 0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    largest = std::max(largest, std::abs(a[n]));
    difference = std::max(difference, std::abs(a[n] - b[n]));
  }
  const std::string name = "coupler/flexible_cavity_16_python";
  ASSERT_GT(largest, 0.01); // it moves
  verify(name, "difference_from_ours", difference / largest, 0, 1e-4);
  verify(name, "iterations_a_step", python.mean_iterations(), ours.mean_iterations(), 0.5);
}

} // namespace
} // namespace drogue::test
