// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/command_line.hpp"

#include <algorithm>

#include <CLI/CLI.hpp>
#include <spdlog/spdlog.h>

#include "common/base/log.hpp"
#include "coupler/check.hpp"
#include "coupler/checkpoints.hpp"
#include "coupler/conform/conform.hpp"
#include "coupler/conform/report.hpp"
#include "coupler/project/project_state.hpp"
#include "coupler/record/replay.hpp"
#include "coupler/run.hpp"
#include "participant/cpp/keys.hpp"

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

int report(const Result<void>& outcome) {
  if (outcome) return 0;
  spdlog::error("{}", outcome.error().message);
  return exit_status(outcome.error());
}

int run(const std::string& file, bool record) {
  config::Report errors;
  const CaseSettings settings = check_case(file, errors);
  if (!errors.ok()) return fail(errors.as_error());
  return report(run_case(settings, record));
}

constexpr const char* record_help = "keep every message in RUN_DIR/record, for coupler replay";

CLI::App* add_resume(CLI::App& app, Resume& resume, bool& verbose) {
  CLI::App* command = app.add_subcommand("resume", "continue a run from its newest checkpoint");
  command->add_option("RUN_DIR", resume.run_directory, "the run's folder")->required();
  command->add_option("--from", resume.step, "continue from the checkpoint of this step");
  command->add_flag("--accept-changes", resume.accept_changes,
                    "continue although configs or meshes have changed since the checkpoint");
  command->add_flag("-v,--verbose", verbose, "log every coupling iteration");
  command->add_flag("--record", resume.record, record_help);
  return command;
}

struct CheckpointCommand {
  std::string run_directory;
  double timeout = 3600; ///< seconds
};

CLI::App* add_checkpoint(CLI::App& app, CheckpointCommand& c) {
  CLI::App* command =
      app.add_subcommand("checkpoint", "have a running coupler write a checkpoint after its present step");
  command->add_option("RUN_DIR", c.run_directory, "the run's folder")->required();
  command->add_option("--timeout", c.timeout, "longest wait [seconds]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  return command;
}

int checkpoint(const CheckpointCommand& c) {
  const auto step = request_checkpoint(c.run_directory, std::chrono::duration<double>(c.timeout));
  if (!step) return fail(step.error());
  fmt::print("checkpoint of step {} in {}\n", *step, CheckpointStore(c.run_directory).folder(*step).string());
  return 0;
}

/// Declares `project` and its options, which are read into `c`.
CLI::App* add_project(CLI::App& app, ProjectCommand& c) {
  CLI::App* command = app.add_subcommand(
      "project", "project a field from one surface to another without any solver, to judge a pair of meshes");
  command->add_option("FROM", c.from, "mesh the field comes from (*.msh)")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("TO", c.to, "mesh it goes to (*.msh)")->required()->check(CLI::ExistingFile);
  command->add_option("--from-group", c.from_group, "surface in FROM; default: its only one");
  command->add_option("--to-group", c.to_group, "surface in TO; default: its only one");
  auto* field = command->add_option_group("field", "what is projected")->require_option(1);
  field->add_option(
      "-e,--expression", c.expression,
      "expressions of x, y, z for the three components, as \"x; y*z; 0\", or one for the first");
  field->add_option("-f,--field", c.field, "field on the nodes of FROM (NodeData of the file)");
  field->add_option("-s,--state", c.state, "state of a structure on FROM (*.state): the result is one on TO");
  command->add_option("-o,--output", c.output, "result on TO (*.vtu, or *.state)")->capture_default_str();
  command->add_option("--largest-gap", c.settings.largest_gap, "as projection.largest_gap of a case")
      ->capture_default_str();
  command
      ->add_option("--largest-unmatched-area", c.settings.largest_unmatched_area,
                   "as projection.largest_unmatched_area")
      ->capture_default_str();
  command
      ->add_option("--largest-normal-angle", c.settings.largest_normal_angle,
                   "as projection.largest_normal_angle [degrees]")
      ->capture_default_str();
  command->add_option("--quadrature-order", c.settings.quadrature_order, "as projection.quadrature_order")
      ->capture_default_str();
  return command;
}

int project_field(const ProjectCommand& command) {
  const auto outcome = command.state.empty() ? project(command) : project_state(command);
  if (!outcome) return fail(outcome.error());
  return 0;
}

/// Declares `conform` and its options, which are read into `c`.
CLI::App* add_conform(CLI::App& app, ConformCommand& c) {
  CLI::App* command = app.add_subcommand(
      "conform", "play a scripted coupler against one participant and check every promise of the protocol");
  command->add_option("COMMAND", c.command, "after --: the participant's program and its arguments");
  command->add_option("--as", c.role, "its role; default: what its fields make it")
      ->check(CLI::IsMember({"fluid", "structure", "mesh_mover"}));
  command->add_option("--json", c.json, "the report as a file");
  command->add_option("--only", c.only, "check these promises alone (names as in the report)")
      ->check(CLI::IsMember(conform::Report::names()));
  command->add_option("--folder", c.folder, "keep logs and results here; default: a temporary folder");
  command->add_option("--time-step", c.sizes.time_step, "length of the steps [time]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--displacement", c.sizes.displacement,
                   "motion of a step, relative to the size of the interface")
      ->capture_default_str();
  command->add_option("--load", c.sizes.load, "pressure or traction on the interface [stress]")
      ->capture_default_str();
  command->add_option("--deadline", c.deadline, "longest wait for an answer [seconds]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  return command;
}

/// What follows the first "--" of `coupler conform ... -- PROGRAM ARGUMENTS`, and of replay; argc is cut
/// there.
std::vector<std::string> cut_command(int& argc, char** argv) {
  const std::string_view first = argc < 2 ? "" : argv[1];
  if (first != "conform" && first != "replay") return {};
  char** const end = argv + argc;
  char** const dashes = std::find_if(argv, end, [](const char* a) { return std::string_view(a) == "--"; });
  if (dashes == end) return {};
  argc = static_cast<int>(dashes - argv);
  return {dashes + 1, end};
}

CLI::App* add_replay(CLI::App& app, ReplayCommand& c) {
  CLI::App* command = app.add_subcommand(
      "replay", "play the coupler's side of a recorded run to one participant, and compare its answers");
  command->add_option("RECORD", c.record, "RUN_DIR/record/NAME.record, of coupler run --record")->required();
  command->add_option("COMMAND", c.command, "after --: the participant's program and its arguments");
  command->add_option("--folder", c.folder, "of logs and results")->capture_default_str();
  command->add_option("--deadline", c.deadline, "longest wait for an answer [seconds]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  return command;
}

int replay_record(const ReplayCommand& command) {
  if (command.command.empty())
    return fail(config_error("replay needs a program: coupler replay RECORD -- PROGRAM ARGUMENTS"));
  if (const auto outcome = replay(command); !outcome) return fail(outcome.error());
  return 0;
}

struct KeygenCommand {
  std::vector<std::string> names;
  std::string folder = ".";
};

CLI::App* add_keygen(CLI::App& app, KeygenCommand& c) {
  CLI::App* command = app.add_subcommand(
      "keygen",
      "make key pairs for participants on other machines: NAME.key to keep secret, NAME.pub for the case");
  command->add_option("NAME", c.names, "whose, e.g. coupler fluid")->required();
  command->add_option("--folder", c.folder, "where the files go")
      ->check(CLI::ExistingDirectory)
      ->capture_default_str();
  return command;
}

int make_keys(const KeygenCommand& command) {
  for (const std::string& name : command.names) {
    const auto pair = keys::make();
    if (!pair) return fail(pair.error());
    if (const auto written = keys::write(command.folder, name, *pair); !written) return fail(written.error());
    fmt::print("{}/{}.key and .pub, public key {}\n", command.folder, name, pair->public_half);
  }
  return 0;
}

int conform_to_protocol(const ConformCommand& command) {
  if (command.command.empty())
    return fail(config_error("conform needs a program: coupler conform -- PROGRAM ARGUMENTS"));
  if (const auto outcome = check_conformance(command); !outcome) return fail(outcome.error());
  return 0;
}

} // namespace

int command_line(int argc, char** argv) {
  start_log("coupler");
  CLI::App app(
      "Leads a partitioned fluid-structure simulation: starts the solvers, iterates, projects, writes.");
  app.require_subcommand(1);
  std::string file;
  bool verbose = false, record = false;
  CLI::App* run_command = app.add_subcommand("run", "run a case");
  run_command->add_option("CASE", file, "the case file (*.textproto)")->required();
  run_command->add_flag("-v,--verbose", verbose, "log every coupling iteration");
  run_command->add_flag("--record", record, record_help);
  CLI::App* check_command =
      app.add_subcommand("check", "check every config of a case, without running anything");
  check_command->add_option("CASE", file, "the case file (*.textproto)")->required();
  ProjectCommand projection;
  const CLI::App* project_command = add_project(app, projection);
  Resume resume;
  const CLI::App* resume_command = add_resume(app, resume, verbose);
  CheckpointCommand wanted;
  const CLI::App* checkpoint_command = add_checkpoint(app, wanted);
  ConformCommand conformance;
  const std::vector<std::string> subject = cut_command(argc, argv);
  const CLI::App* conform_command = add_conform(app, conformance);
  ReplayCommand repetition;
  repetition.folder = "replay";
  const CLI::App* replay_command = add_replay(app, repetition);
  KeygenCommand new_keys;
  const CLI::App* keygen_command = add_keygen(app, new_keys);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : static_cast<int>(ErrorKind::config);
  }
  conformance.command.insert(conformance.command.end(), subject.begin(), subject.end());
  repetition.command.insert(repetition.command.end(), subject.begin(), subject.end());
  if (*replay_command) return replay_record(repetition);
  if (*keygen_command) return make_keys(new_keys);
  if (*conform_command) return conform_to_protocol(conformance);
  if (*project_command) return project_field(projection);
  if (verbose) spdlog::set_level(spdlog::level::debug);
  if (*check_command) return check(file);
  if (*checkpoint_command) return checkpoint(wanted);
  return *resume_command ? report(resume_run(resume)) : run(file, record);
}

} // namespace drogue::coupler
