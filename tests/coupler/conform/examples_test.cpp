// SPDX-License-Identifier: GPL-3.0-or-later
// The examples keep every promise of the protocol; those in C, C++ and Fortran are built against the
// installed package.
#include <cstdlib>

#include "tests/support/checkpoint_runs.hpp"

namespace drogue::test {
namespace {

constexpr const char* examples = DROGUE_SOURCE_DIR "/examples";

void expect_conform(const std::string& program) {
  const auto folder = fresh_folder("conform");
  std::vector<std::string> command{"conform", "--"};
  std::istringstream words(program);
  for (std::string word; words >> word;) command.push_back(word);
  EXPECT_EQ(run_coupler_with(folder, command), 0) << read_text(folder / "output.txt");
}

TEST(ConformExamples, FluidInC) {
  expect_conform(DROGUE_EXAMPLES_DIR
                 "/c_piston_fluid/piston_fluid fluid --impedance 3 --size 1 1 --cells 3 2");
}

TEST(ConformExamples, MeshMoverInC) {
  expect_conform(DROGUE_EXAMPLES_DIR "/c_piston_fluid/piston_fluid mesh_mover --size 1 1 --cells 3 2");
}

TEST(ConformExamples, StructureInCpp) {
  expect_conform(DROGUE_EXAMPLES_DIR "/cpp_spring/spring --mass 1 --stiffness 4 --start 0.1");
}

TEST(ConformExamples, StructureInFortran) {
  const std::string program = DROGUE_EXAMPLES_DIR "/fortran_spring/spring";
  if (!std::filesystem::exists(program)) GTEST_SKIP() << "gfortran is not installed";
  expect_conform(program + " 1 4 0.1");
}

TEST(ConformExamples, CableInPython) {
  expect_conform(
      fmt::format("{} {}/python_cable/cable.py --from 0 0 --to 1 0 --line-density 0.03 --tension 1 "
                  "--stiffness 0.01 --start 0.001",
                  DROGUE_PYTHON, examples));
}

TEST(ConformExamples, CalculixThroughPython) {
  if (std::system("command -v ccx > /dev/null") != 0)
    GTEST_SKIP() << "CalculiX is not installed (calculix-ccx)";
  expect_conform(fmt::format(
      "{} {}/python_calculix/calculix_structure.py --deck {}/python_calculix/bar.inp --surface WET",
      DROGUE_PYTHON, examples, examples));
}

} // namespace
} // namespace drogue::test
