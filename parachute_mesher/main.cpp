// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdio>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "common/base/log.hpp"
#include "parachute_mesher/commands.hpp"

int main(int argc, char** argv) {
  using namespace drogue;
  start_log("parachute_mesher");
  CLI::App app("Makes the structure and fluid meshes of a parachute");
  app.require_subcommand(1);
  std::string file;
  Result<void> (*command)(const std::filesystem::path&) = nullptr;
  const auto add = [&](const char* name, const char* what, auto function, const char* argument) {
    CLI::App* sub = app.add_subcommand(name, what);
    sub->add_option(argument, file)->required();
    sub->callback([&command, function] { command = function; });
  };
  add("structure", "write the flat structure mesh of a config", parachute::write_structure_mesh, "FILE");
  add("fluid", "write the fluid mesh around the inflated canopy", parachute::write_fluid_mesh, "FILE");
  add("info", "describe a mesh and its quality", parachute::print_info, "MESH");
  add("check", "validate a config", parachute::check_config, "FILE");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const Result<void> done = command(file);
  if (done) return 0;
  fmt::print(stderr, "{}\n", done.error().message);
  return exit_status(done.error());
}
