// SPDX-License-Identifier: GPL-3.0-or-later
#include <optional>

#include "common/la_krylov/session.hpp"
#include "common/meshing/remesh.hpp"
#include "common/program/solver_program.hpp"
#include "fluid_solver/program.hpp"

int main(int argc, char** argv) {
  using namespace drogue;
  std::optional<la::Session> session; // started when there is something to do; outlives every solver
  const auto start = [&]() -> Result<void> {
    auto started = la::Session::start();
    if (!started) return started.error();
    session.emplace(std::move(*started));
    return {};
  };
  const auto check = [&](const std::string& file, Role role) -> Result<void> {
    DROGUE_TRY(start());
    return fluid::check(file, role);
  };
  const auto run = [&](const std::string& file, const std::string& endpoint) -> Result<void> {
    DROGUE_TRY(start());
    return fluid::run(file, endpoint);
  };
  return run_solver_program({.name = "fluid_solver",
                             .description = "Incompressible flow on tetrahedra, semi-discrete and DSD/SST",
                             .check = check,
                             .run = run,
                             .remesh = meshing::remesh_file,
                             .speaks = [&] { return !session || la::rank() == 0; }},
                            argc, argv);
}
