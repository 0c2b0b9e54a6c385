// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>

#include "common/base/log.hpp"
#include "common/la_krylov/session.hpp"
#include "fluid_solver/program.hpp"

int main(int argc, char** argv) {
  using namespace drogue;
  CLI::App app("Incompressible flow on tetrahedra, semi-discrete and DSD/SST", "fluid_solver");
  app.require_subcommand(1);
  std::string file;
  std::string endpoint;
  auto* run = app.add_subcommand("run", "Runs a config, alone or as a participant of a coupled run");
  run->add_option("FILE", file, "config (*.textproto)")->required();
  run->add_option("--connect", endpoint, "where the coupler listens; makes this a participant");
  auto* check = app.add_subcommand("check", "Validates a config and its mesh; reports every error at once");
  check->add_option("FILE", file, "config (*.textproto)")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  start_log("fluid_solver");
  const auto session = la::Session::start(); // outlives every solver
  const auto done = !session          ? Result<void>(session.error())
                    : check->parsed() ? fluid::check(file)
                                      : fluid::run(file, endpoint);
  if (done) return 0;
  if (!session || la::rank() == 0) fmt::print(stderr, "{}\n", done.error().message);
  return exit_status(done.error());
}
