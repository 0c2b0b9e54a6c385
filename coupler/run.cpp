// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/run.hpp"

#include <algorithm>
#include <cstdio>

#include <fmt/ranges.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "coupler/check.hpp"
#include "coupler/checkpoints.hpp"
#include "coupler/healing.hpp"
#include "coupler/inputs.hpp"
#include "coupler/record/recorder.hpp"
#include "coupler/run_directory.hpp"
#include "coupler/scheme/step_loop.hpp"
#include "coupler/stop.hpp"

namespace drogue::coupler {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// A line on a terminal that is written over, plain log lines otherwise.
class Progress {
 public:
  Progress(int steps, int done_before)
      : steps_(steps), done_before_(done_before), terminal_(isatty(STDERR_FILENO) == 1) {}
  void step(int done, double time, int iterations, const IterationRecord& last) {
    const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
    const double cost = elapsed / (done - done_before_);
    const std::string line =
        fmt::format("step {}/{}  t {:.4g}  {} iterations  residual {:.1e}  {:.2f} s/step  {:.0f} s left",
                    done, steps_, time, iterations, last.residual_relative, cost, cost * (steps_ - done));
    if (!terminal_) return spdlog::info("{}", line);
    fmt::print(stderr, "\r\033[K{}{}", line, done == steps_ ? "\n" : "");
    std::fflush(stderr);
  }

 private:
  int steps_, done_before_;
  bool terminal_;
  Clock::time_point start_ = Clock::now();
};

/// What iteration suits, where H carries about -ratio of a change of d back.
std::string advice(double ratio) {
  if (ratio < 0.3) return "any iteration converges, CONSTANT with relaxation 1 too";
  if (ratio < 3)
    return fmt::format("AITKEN or IQN_ILS, first relaxation about {:.1g}; a plain iteration {}",
                       1 / (1 + ratio), ratio < 1 ? "is slow" : "diverges");
  return fmt::format(
      "IQN_ILS or IQN_IMVJ that keep secants, first relaxation about {:.1g}; a plain iteration diverges",
      1 / (1 + ratio));
}

void summarise(const LoopTotals& totals, Participants& participants, double seconds) {
  spdlog::info(
      "{} steps{}, {} iterations: {:.2f} a step on average, {} at most; {} not converged, {} retried",
      totals.steps, totals.parts > totals.steps ? fmt::format(" (done in {} parts)", totals.parts) : "",
      totals.iterations, static_cast<double>(totals.iterations) / std::max(totals.steps, 1),
      totals.most_iterations, totals.unconverged, totals.retries);
  if (totals.new_meshes > 0)
    spdlog::info("the fluid's mesh was replaced {} times: remesh.csv", totals.new_meshes);
  if (totals.dropped_columns > 0)
    spdlog::info("acceleration: {:.1f} secants an iteration on average, {:.1f} more left out by the filter",
                 totals.used_columns / std::max(totals.iterations, 1),
                 totals.dropped_columns / std::max(totals.iterations, 1));
  if (totals.added_mass_ratio > 0)
    spdlog::info("added mass: the fluid answers with about {:.2g} times the structure's own resistance "
                 "(inertia, and stiffness "
                 "over a step): {}",
                 totals.added_mass_ratio, advice(totals.added_mass_ratio));
  double everyone = 0;
  std::string shares;
  for (const auto& peer : participants.hub().peers()) {
    everyone += peer->busy_seconds;
    shares += fmt::format("{} {:.1f} s ({:.0f} %), ", peer->name, peer->busy_seconds,
                          100 * peer->busy_seconds / seconds);
  }
  spdlog::info("time {:.1f} s: {}coupler and transport {:.1f} s", seconds, shares,
               std::max(0.0, seconds - everyone));
  std::string memory;
  for (const auto& peer : participants.hub().peers())
    if (peer->process) memory += fmt::format("{} {:.0f} MB, ", peer->name, peer->peak_memory_mb());
  spdlog::info("peak memory: {}coupler {:.0f} MB", memory, launcher::peak_memory_mb(getpid()));
}

struct Case {
  const CaseSettings& settings;
  const fs::path& directory;
  Start start;
  bool record = false;
  std::optional<Origin> origin = {}; ///< of a run that goes on from another one
};

std::string how_to_resume(const fs::path& directory) {
  return fmt::format("continue it with: coupler resume {}", directory.string());
}

/// @return the last step done: fewer than the case's when a stop in order was asked for
Result<std::uint64_t> run_steps(const Case& c, Participants& participants, std::vector<Input> inputs) {
  const CaseSettings& settings = c.settings;
  const std::string unable = participants.who_cannot_checkpoint();
  if (settings.checkpoints.asked() && !unable.empty())
    return config_error("the case asks for checkpoints, but {} cannot give one", unable);
  auto exchange = Exchange::create(participants, settings);
  if (!exchange) return exchange.error();
  auto results = Results::create(c.directory, c.start.resumed ? io::Existing::keep : io::Existing::replace);
  if (!results) return results.error();
  auto loop = StepLoop::create(participants, *exchange, *results, settings);
  if (!loop) return loop.error();
  Checkpoints checkpoints(settings, participants, *loop, *results, c.directory, std::move(inputs));
  std::uint64_t done = c.start.step;
  if (c.start.resumed) {
    DROGUE_TRY(checkpoints.restore(done));
  } else if (c.origin) {
    DROGUE_TRY(checkpoints.start_from(*c.origin));
    done = c.origin->step;
  }

  stop::set_orderly(unable.empty());
  const auto start = Clock::now();
  const auto last = static_cast<std::uint64_t>(settings.steps);
  Progress progress(settings.steps, static_cast<int>(done));
  const auto time = [&](std::uint64_t step) { return static_cast<double>(step) * settings.time_step; };
  while (done < last && !stop::requested()) { // steps are counted, times are computed: no drift
    const int before = loop->totals().iterations;
    const auto finished = loop->advance(done + 1, time(done), settings.time_step);
    if (!finished) return finished.error();
    if (!*finished) break;
    ++done;
    progress.step(static_cast<int>(done), time(done), loop->totals().iterations - before, loop->last());
    DROGUE_TRY(checkpoints.after_step(done, time(done)));
  }
  // The end, too: a run with more steps, or another one (start_from), may go on from it.
  if (done < last || settings.checkpoints.asked()) DROGUE_TRY(checkpoints.write(done, time(done)));
  summarise(loop->totals(), participants, std::chrono::duration<double>(Clock::now() - start).count());
  return done;
}

/// The solvers' part of a run: from their start to their end.
Result<void> launch_and_run(const Case& c) {
  std::vector<Input> inputs = inputs_of(c.settings);
  std::optional<record::Recorder> recorder;
  if (c.record) recorder.emplace(c.directory);
  auto participants =
      Participants::launch(c.settings, c.directory, c.start.resumed, recorder ? &*recorder : nullptr);
  if (!participants) return participants.error();
  const auto done = run_steps(c, **participants, std::move(inputs));
  stop::set_orderly(false);
  if (!done) {
    (*participants)->hub().abort(done.error().message);
    return done.error();
  }
  DROGUE_TRY((*participants)->hub().shut_down(launcher::Seconds(c.settings.deadlines.shutdown)));
  if (*done == static_cast<std::uint64_t>(c.settings.steps)) return {};
  return Error{ErrorKind::interrupted, fmt::format("stopped by a signal after step {} of {}; {}", *done,
                                                   c.settings.steps, how_to_resume(c.directory))};
}

Result<void> run(Case c) {
  Healing healing(c.settings, c.directory);
  auto outcome = launch_and_run(c);
  while (!outcome) {
    const auto start = healing.after(outcome.error());
    if (!start) break;
    c.start = *start;
    outcome = launch_and_run(c);
  }
  if (outcome) {
    spdlog::info("results in {}", c.directory.string());
    return {};
  }
  Error error = outcome.error();
  // Signals may reach the solvers as well: their deaths then are no fault of theirs.
  if (stop::requested() && error.kind == ErrorKind::peer) error.kind = ErrorKind::interrupted;
  const auto kept = CheckpointStore(c.directory).steps();
  if (!kept.empty() && error.message.find("coupler resume") == std::string::npos)
    error.message +=
        fmt::format("\nthere is a checkpoint of step {}; {}", kept.back(), how_to_resume(c.directory));
  return error;
}

void log_into(const fs::path& directory) {
  spdlog::default_logger()->sinks().push_back(
      std::make_shared<spdlog::sinks::basic_file_sink_mt>((directory / "coupler.log").string()));
}

Result<void> accept(const Manifest& manifest, const CaseSettings& settings, bool accept_changes) {
  const auto changes = differences(manifest, settings);
  if (changes.empty()) return {};
  const std::string what =
      fmt::format("since the checkpoint of step {}: {}", manifest.step, fmt::join(changes, "; "));
  if (!accept_changes)
    return config_error("{}. Put back what was there, or resume with --accept-changes", what);
  spdlog::warn("{}: accepted as asked; the results are not those of one undisturbed run", what);
  return {};
}

} // namespace

Result<void> run_case(const CaseSettings& settings, bool record) {
  stop::catch_signals();
  const auto held = RunDirectory::create(settings.run_directory);
  if (!held) return held.error();
  const fs::path& directory = held->path();
  log_into(directory);
  std::error_code ignored;
  fs::copy_file(settings.file, directory / settings.file.filename(), ignored);
  spdlog::info("case \"{}\" in {}", settings.name, directory.string());
  std::optional<Origin> origin;
  if (!settings.start_from.empty()) {
    auto kept = keep_origin(settings, directory);
    if (!kept) return kept.error();
    origin = std::move(*kept);
  }
  return run({settings, directory, {}, record, origin});
}

Result<void> resume_run(const Resume& resume) {
  stop::catch_signals();
  const auto held = RunDirectory::reopen(resume.run_directory);
  if (!held) return held.error();
  const fs::path& directory = held->path();
  log_into(directory);
  const auto manifest = CheckpointStore(directory).newest_whole(resume.step);
  if (!manifest) return manifest.error();
  config::Report report;
  const CaseSettings settings = check_case(manifest->case_file.path, report);
  if (!report.ok()) return report.as_error();
  DROGUE_TRY(accept(*manifest, settings, resume.accept_changes));
  spdlog::info("case \"{}\" in {} goes on after step {} (t = {:g})", settings.name, directory.string(),
               manifest->step, manifest->time);
  if (manifest->step >= static_cast<std::uint64_t>(settings.steps)) {
    spdlog::info("nothing is left to do: {} has {} steps", settings.file.string(), settings.steps);
    return {};
  }
  return run({settings, directory, {manifest->step, true}, resume.record});
}

} // namespace drogue::coupler
