// SPDX-License-Identifier: GPL-3.0-or-later
// The undisturbed life of the participant: all others are compared with it.
#include <csignal>
#include <set>

#include <fmt/ranges.h>

#include "coupler/conform/script.hpp"
#include "coupler/scheme/contract.hpp"

namespace drogue::coupler::conform {
namespace {

using Body = v1::Envelope;

/// A wait this long must have seen beats.
constexpr double long_work = 2.5;

Result<void> check_processes(const v1::Hello& hello) {
  if (hello.pid().empty()) return peer_error("Hello names no process");
  for (const std::int64_t pid : hello.pid())
    if (pid <= 0 || kill(static_cast<pid_t>(pid), 0) != 0) return peer_error("there is no process {}", pid);
  return {};
}

Result<void> check_fields(const std::string& role, const v1::Hello& hello) {
  for (const auto* list : {&hello.input(), &hello.output()}) {
    std::set<std::string> names;
    for (const v1::FieldContract& f : *list) {
      if (f.name().empty()) return peer_error("a field has no name");
      if (!names.insert(f.name()).second) return peer_error("two fields are called \"{}\"", f.name());
      if (f.quantity() == v1::FieldContract::QUANTITY_UNSPECIFIED ||
          f.location() == v1::FieldContract::LOCATION_UNSPECIFIED ||
          f.time_level() == v1::FieldContract::TIME_LEVEL_UNSPECIFIED || f.components() == 0)
        return peer_error("\"{}\" lacks its quantity, location, time level or components", f.name());
    }
  }
  return check_role(role, role, hello);
}

/// Every output of the contract, in its shape, finite.
Result<void> check_outputs(const Record& record, const wire::Message& answer) {
  for (const v1::FieldContract& f : record.hello.output()) {
    const auto it = answer.floats.find(f.name());
    if (it == answer.floats.end()) {
      if (f.optional()) continue;
      return peer_error("output \"{}\" is missing", f.name());
    }
    const std::vector<std::uint64_t> expected{rows(f, record.surface), f.components()};
    if (it->second.shape != expected)
      return peer_error("output \"{}\" has shape {{{}}}; its contract says {{{}}}", f.name(),
                        fmt::join(it->second.shape, ", "), fmt::join(expected, ", "));
    if (const auto bad = wire::first_not_finite(it->second.values))
      return peer_error("output \"{}\" is not finite at value {}", f.name(), *bad);
  }
  return {};
}

void note(Report& report, std::string_view promise, const Result<void>& outcome) {
  if (outcome)
    report.pass(promise);
  else
    report.fail(promise, outcome.error().message);
}

Result<void> greet(Session& session, Trial& trial, Report& report) {
  const auto said = hello(session);
  note(report, "hello", said ? Result<void>() : said.error());
  if (!said) return said.error();
  trial.record.hello = *said;
  const bool speaks = said->min_version() <= wire::version && wire::version <= said->max_version();
  note(report, "version",
       speaks ? Result<void>()
              : peer_error("it speaks versions {} to {}", said->min_version(), said->max_version()));
  note(report, "processes", check_processes(*said));
  note(report, "contract", check_fields(trial.subject.role, *said));
  return {};
}

Result<void> start(Session& session, Trial& trial) {
  if (const auto got = ask_for(session, configure(trial, session.folder()), Body::kDone); !got)
    return got.error();
  auto initialized = ask_for(session, initialize(), Body::kInitialized);
  if (!initialized) return initialized.error();
  const auto surface = surface_of(*initialized);
  if (!surface) return surface.error();
  trial.record.surface = *surface;
  trial.record.initialized = std::move(*initialized);
  return {};
}

Result<void> do_steps(Session& session, Trial& trial) {
  for (int step = 1; step <= steps; ++step) {
    if (const auto got = ask_for(session, begin_step(trial, step), Body::kDone); !got) return got.error();
    trial.record.answers.emplace_back();
    for (int i = 1; i <= iterations_of_a_step; ++i) {
      auto answer = ask_for(session, iterate(trial, step, i), Body::kIterated);
      if (!answer) return answer.error();
      DROGUE_TRY(check_outputs(trial.record, *answer));
      trial.record.answers.back().push_back(std::move(*answer));
    }
    if (const auto got = ask_for(session, commit(step), Body::kDone); !got) return got.error();
  }
  return {};
}

void judge_beats(const Session& session, Report& report) {
  const double work = session.longest_work();
  const int due = static_cast<int>(work) - 1;
  if (work < long_work)
    report.skip("beats", fmt::format("no answer took longer than {:g} s", long_work));
  else if (session.beats_then() < due)
    report.fail("beats", fmt::format("{} in the {:.1f} s of one answer", session.beats_then(), work));
  else
    report.pass("beats");
}

} // namespace

bool check_reference(Trial& trial, Report& report) {
  bool complete = false;
  play(trial, report, "reference", {"identity"}, [&](Session& session) -> Result<void> {
    if (!greet(session, trial, report)) return {};
    const auto started = start(session, trial);
    note(report, "initialize", started);
    if (!started) return {};
    const auto stepped = do_steps(session, trial);
    note(report, "iterate", stepped);
    judge_beats(session, report);
    complete = stepped.ok();
    return {};
  });
  return complete;
}

} // namespace drogue::coupler::conform
