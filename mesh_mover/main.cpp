// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>

#include "common/base/log.hpp"
#include "mesh_mover/program.hpp"

int main(int argc, char** argv) {
  using namespace drogue;
  CLI::App app("Moves a fluid mesh with its boundaries: an elastic pseudo-solid on tetrahedra", "mesh_mover");
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
  start_log("mesh_mover");
  const auto done = check->parsed() ? mesh_mover::check(file) : mesh_mover::run(file, endpoint);
  if (done) return 0;
  fmt::print(stderr, "{}\n", done.error().message);
  return exit_status(done.error());
}
