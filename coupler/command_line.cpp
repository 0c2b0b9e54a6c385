// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/command_line.hpp"

#include <CLI/CLI.hpp>
#include <spdlog/spdlog.h>

#include "common/base/log.hpp"
#include "coupler/check.hpp"
#include "coupler/run.hpp"

namespace drogue::coupler {
namespace {

int fail(const Error& error) {
  fmt::print(stderr, "{}\n", error.message);
  return exit_status(error);
}

int check(const std::string& file) {
  config::Report report;
  (void)check_case(file, report);
  if (!report.ok()) return fail(report.as_error());
  fmt::print("{}: ok\n", file);
  return 0;
}

int run(const std::string& file) {
  config::Report report;
  const CaseSettings settings = check_case(file, report);
  if (!report.ok()) return fail(report.as_error());
  if (const auto outcome = run_case(settings); !outcome) {
    spdlog::error("{}", outcome.error().message);
    return exit_status(outcome.error());
  }
  return 0;
}

} // namespace

int command_line(int argc, char** argv) {
  start_log("coupler");
  CLI::App app(
      "Leads a partitioned fluid-structure simulation: starts the solvers, iterates, projects, writes.");
  app.require_subcommand(1);
  std::string file;
  bool verbose = false;
  CLI::App* run_command = app.add_subcommand("run", "run a case");
  run_command->add_option("CASE", file, "the case file (*.textproto)")->required();
  run_command->add_flag("-v,--verbose", verbose, "log every coupling iteration");
  CLI::App* check_command =
      app.add_subcommand("check", "check every config of a case, without running anything");
  check_command->add_option("CASE", file, "the case file (*.textproto)")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : static_cast<int>(ErrorKind::config);
  }
  if (verbose) spdlog::set_level(spdlog::level::debug);
  return *check_command ? check(file) : run(file);
}

} // namespace drogue::coupler
