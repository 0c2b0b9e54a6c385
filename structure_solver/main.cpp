// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/program/solver_program.hpp"
#include "structure_solver/coupled.hpp"
#include "structure_solver/run.hpp"

namespace {

using namespace drogue;

Result<void> run(const std::string& file, const std::string& endpoint) {
  if (endpoint.empty()) return structure::run_file(file);
  auto c = structure::load_case(file, Role::participant);
  if (!c) return c.error();
  structure::Coupled solver(std::move(*c));
  participant::Subcycled in_parts(solver, solver.parts(), solver.interpolation());
  participant::Solver& served_solver =
      solver.parts() > 1 ? static_cast<participant::Solver&>(in_parts) : solver;
  const Result<void> served =
      participant::serve(served_solver, participant::serve_options_from_environment(endpoint));
  const Result<void> finished = solver.finish();
  return served ? finished : served;
}

} // namespace

int main(int argc, char** argv) {
  return run_solver_program(
      {.name = "structure_solver",
       .description = "Membranes, cables and masses: large displacements, statics and dynamics, "
                      "alone or coupled",
       .check = [](const std::string& file, Role role) { return structure::check_case(file, role); },
       .run = run},
      argc, argv);
}
