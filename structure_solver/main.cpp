// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdio>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "common/base/log.hpp"
#include "structure_solver/coupled.hpp"
#include "structure_solver/run.hpp"

namespace {

drogue::Result<void> run_coupled(const std::string& file, const std::string& endpoint) {
  auto c = drogue::structure::load_case(file);
  if (!c) return c.error();
  drogue::structure::Coupled solver(std::move(*c));
  return drogue::participant::serve(solver, drogue::participant::serve_options_from_environment(endpoint));
}

} // namespace

int main(int argc, char** argv) {
  using namespace drogue;
  start_log("structure_solver");
  CLI::App app("Membranes, cables and masses: large displacements, statics and dynamics, alone or coupled");
  app.require_subcommand(1);
  std::string file, endpoint;
  CLI::App* run = app.add_subcommand("run", "run a config alone, or as a participant");
  run->add_option("FILE", file)->required();
  run->add_option("--connect", endpoint, "endpoint of the coupler");
  CLI::App* check = app.add_subcommand("check", "validate a config with its mesh");
  check->add_option("FILE", file)->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const Result<void> done = *check             ? structure::check_case(file)
                            : endpoint.empty() ? structure::run_file(file)
                                               : run_coupled(file, endpoint);
  if (done) return 0;
  fmt::print(stderr, "{}\n", done.error().message);
  return exit_status(done.error());
}
