// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/program/solver_program.hpp"

#include <cstdio>
#include <cstdlib>

#include <CLI/CLI.hpp>

#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"

namespace drogue {

int run_solver_program(const SolverProgram& program, int argc, char** argv) {
  CLI::App app(program.description, program.name);
  app.require_subcommand(1);
  std::string file, endpoint;
  CLI::App* run = app.add_subcommand("run", "runs a config, alone or as a participant of a coupled run");
  run->add_option("FILE", file, "config (*.textproto)")->required();
  run->add_option("--connect", endpoint, "where the coupler listens; makes this a participant");
  CLI::App* check =
      app.add_subcommand("check", "validates a config and its mesh; reports every error at once");
  check->add_option("FILE", file, "config (*.textproto)")->required();
  bool participant = std::getenv("DROGUE_PARTICIPANT") != nullptr;
  check->add_flag("--participant", participant,
                  "for a coupled run; also when DROGUE_PARTICIPANT is set in the environment");
  std::string to;
  CLI::App* remesh = nullptr;
  if (program.remesh) {
    remesh = app.add_subcommand("remesh", "meshes the volume of a mesh anew; its boundary stays as it is");
    remesh->add_option("FROM", file, "mesh (*.msh) of tetrahedra")->required();
    remesh->add_option("TO", to, "where the new mesh is written (*.msh)")->required();
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ErrorKind::config);
  }
  start_log(program.name);
  if (run->parsed()) catch_interrupts();
  const auto chosen = [&]() -> Result<void> {
    if (check->parsed()) return program.check(file, participant ? Role::participant : Role::alone);
    if (remesh && remesh->parsed()) return program.remesh(file, to);
    return program.run(file, endpoint);
  };
  const Result<void> done = chosen();
  if (done) return 0;
  if (program.speaks()) fmt::print(stderr, "{}\n", done.error().message);
  return exit_status(done.error());
}

} // namespace drogue
