// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/run.hpp"

#include <csignal>
#include <cstdio>

#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "coupler/run_directory.hpp"
#include "coupler/scheme/step_loop.hpp"

namespace drogue::coupler {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

void on_signal(int) {
  launcher::Hub::interrupt();
}

/// A line on a terminal that is written over, plain log lines otherwise.
class Progress {
 public:
  explicit Progress(int steps) : steps_(steps), terminal_(isatty(STDERR_FILENO) == 1) {}
  void step(int done, double time, int iterations, const IterationRecord& last) {
    const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
    const double cost = elapsed / done;
    const std::string line =
        fmt::format("step {}/{}  t {:.4g}  {} iterations  residual {:.1e}  {:.2f} s/step  {:.0f} s left",
                    done, steps_, time, iterations, last.residual_relative, cost, cost * (steps_ - done));
    if (!terminal_) return spdlog::info("{}", line);
    fmt::print(stderr, "\r\033[K{}{}", line, done == steps_ ? "\n" : "");
    std::fflush(stderr);
  }

 private:
  int steps_;
  bool terminal_;
  Clock::time_point start_ = Clock::now();
};

void summarise(const LoopTotals& totals, Participants& participants, double seconds) {
  spdlog::info(
      "{} steps{}, {} iterations: {:.2f} a step on average, {} at most; {} not converged, {} retried",
      totals.steps, totals.parts > totals.steps ? fmt::format(" (done in {} parts)", totals.parts) : "",
      totals.iterations, static_cast<double>(totals.iterations) / std::max(totals.steps, 1),
      totals.most_iterations, totals.unconverged, totals.retries);
  if (totals.dropped_columns > 0)
    spdlog::info("acceleration: {:.1f} secants an iteration on average, {:.1f} more left out by the filter",
                 totals.used_columns / std::max(totals.iterations, 1),
                 totals.dropped_columns / std::max(totals.iterations, 1));
  spdlog::info("added mass: the fluid answers with about {:.2g} times the structure's own inertia",
               totals.added_mass_ratio);
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
    memory += fmt::format("{} {:.0f} MB, ", peer->name, peer->peak_memory_mb());
  spdlog::info("peak memory: {}coupler {:.0f} MB", memory, launcher::peak_memory_mb(getpid()));
}

Result<void> run_steps(const CaseSettings& settings, Participants& participants, const fs::path& directory) {
  auto exchange = Exchange::create(participants, settings);
  if (!exchange) return exchange.error();
  auto results = Results::create(directory);
  if (!results) return results.error();
  auto loop = StepLoop::create(participants, *exchange, *results, settings);
  if (!loop) return loop.error();
  const auto start = Clock::now();
  Progress progress(settings.steps);
  for (int n = 0; n < settings.steps; ++n) { // steps are counted, times are computed: no drift
    const int before = loop->totals().iterations;
    DROGUE_TRY(loop->advance(static_cast<std::uint64_t>(n) + 1, n * settings.time_step, settings.time_step));
    progress.step(n + 1, (n + 1) * settings.time_step, loop->totals().iterations - before, loop->last());
  }
  summarise(loop->totals(), participants, std::chrono::duration<double>(Clock::now() - start).count());
  return {};
}

} // namespace

Result<void> run_case(const CaseSettings& settings) {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  std::signal(SIGPIPE, SIG_IGN);
  const auto held = RunDirectory::create(settings.run_directory);
  if (!held) return held.error();
  const fs::path& directory = held->path();
  spdlog::default_logger()->sinks().push_back(
      std::make_shared<spdlog::sinks::basic_file_sink_mt>((directory / "coupler.log").string()));
  std::error_code ignored;
  fs::copy_file(settings.file, directory / settings.file.filename(), ignored);

  spdlog::info("case \"{}\" in {}", settings.name, directory.string());
  auto participants = Participants::launch(settings, directory);
  if (!participants) return participants.error();
  if (auto outcome = run_steps(settings, **participants, directory); !outcome) {
    (*participants)->hub().abort(outcome.error().message);
    return outcome.error();
  }
  DROGUE_TRY((*participants)->hub().shut_down(launcher::Seconds(settings.deadlines.shutdown)));
  spdlog::info("results in {}", directory.string());
  return {};
}

} // namespace drogue::coupler
