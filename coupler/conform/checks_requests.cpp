// SPDX-License-Identifier: GPL-3.0-or-later
// Requests that are wrong, repeated or late, and whether they leave a trace.
#include <limits>
#include <thread>

#include "coupler/conform/script.hpp"

namespace drogue::coupler::conform {
namespace {

using participant::ProtocolState;
using Body = v1::Envelope;

constexpr auto pause_length = std::chrono::milliseconds(1200);
/// A second answer to a repeated request comes within this time, or not at all.
constexpr Seconds second_answer{0.3};

void check_again(const Trial& trial, Report& report) {
  play(trial, report, "again", {"deterministic"}, [&](Session& session) -> Result<void> {
    if (const auto said = hello(session); !said) return said.error();
    if (const auto got = ask_for(session, configure(trial, session.folder()), Body::kDone); !got)
      return got.error();
    const auto initialized = ask_for(session, initialize(), Body::kInitialized);
    if (!initialized) return initialized.error();
    DROGUE_TRY(same(trial.record.initialized, *initialized));
    for (int step = 1; step <= steps; ++step) DROGUE_TRY(same_step(session, trial, step));
    return {};
  });
}

void check_pause(const Trial& trial, Report& report) {
  play(trial, report, "pause", {"pause"}, [&](Session& session) -> Result<void> {
    DROGUE_TRY(go_to(session, trial, ProtocolState::in_step));
    std::this_thread::sleep_for(pause_length);
    const auto got = ask_for(session, iterate(trial, 1, 1), Body::kIterated);
    return got ? same(trial.record.answers[0][0], *got) : got.error();
  });
}

std::vector<wire::Message> all_requests(const Trial& trial, const Session& session) {
  return {configure(trial, session.folder()),
          initialize(),
          begin_step(trial, 1),
          iterate(trial, 1, 1),
          commit(1),
          rollback(1),
          checkpoint(session.folder()),
          restore(session.folder()),
          replace_mesh(session.folder() / "none.msh")};
}

/// Every request that does not fit the state.
Result<void> try_wrong_requests(Session& session, const Trial& trial, ProtocolState state) {
  for (wire::Message& request : all_requests(trial, session)) {
    if (participant::next_state(state, request.envelope.body_case())) continue;
    const auto got = ask_for_error(session, std::move(request), v1::Error::WRONG_STATE);
    if (!got) return peer_error("in state {}: {}", participant::name(state), got.error().message);
  }
  return {};
}

void check_wrong_states(const Trial& trial, Report& report) {
  play(trial, report, "wrong_state", {"wrong_state"}, [&](Session& session) -> Result<void> {
    if (const auto said = hello(session); !said) return said.error();
    const auto next = [&](wire::Message request, Body::BodyCase answer,
                          ProtocolState before) -> Result<void> {
      DROGUE_TRY(try_wrong_requests(session, trial, before));
      const auto got = ask_for(session, std::move(request), answer);
      return got ? Result<void>() : got.error();
    };
    DROGUE_TRY(next(configure(trial, session.folder()), Body::kDone, ProtocolState::greeted));
    DROGUE_TRY(next(initialize(), Body::kInitialized, ProtocolState::configured));
    DROGUE_TRY(next(begin_step(trial, 1), Body::kDone, ProtocolState::ready));
    DROGUE_TRY(try_wrong_requests(session, trial, ProtocolState::in_step));
    for (int i = 1; i <= iterations_of_a_step; ++i) {
      const auto got = ask_for(session, iterate(trial, 1, i), Body::kIterated);
      if (!got) return got.error();
      DROGUE_TRY(same(trial.record.answers[0][static_cast<std::size_t>(i - 1)], *got));
      DROGUE_TRY(try_wrong_requests(session, trial, ProtocolState::iterated));
    }
    DROGUE_TRY(next(commit(1), Body::kDone, ProtocolState::iterated));
    DROGUE_TRY(try_wrong_requests(session, trial, ProtocolState::ready));
    return same_step(session, trial, 2);
  });
}

const v1::FieldContract* required_input(const v1::Hello& hello) {
  for (const v1::FieldContract& f : hello.input())
    if (!f.optional()) return &f;
  return nullptr;
}

/// Sends a request that must be refused. @return whether the participant is still there
bool expect_refusal(Session& session, Report& report, std::string_view promise, wire::Message request,
                    v1::Error::Code code, const std::string& named = "") {
  const auto got = ask_for_error(session, std::move(request), code);
  if (!got)
    report.fail(promise, got.error().message);
  else if (got->envelope.error().message().find(named) == std::string::npos)
    report.fail(promise, fmt::format("its text does not name \"{}\": {}", named, answer_text(*got)));
  else
    report.pass(promise);
  return !session.ended();
}

void refuse_inputs(Session& session, const Trial& trial, Report& report) {
  const v1::FieldContract* field = required_input(trial.record.hello);
  if (!field) {
    for (const char* promise : {"missing_input", "bad_shape", "not_finite"})
      report.skip(promise, "it needs no input");
    return;
  }
  wire::Message missing = iterate(trial, 1, 2), shape = missing, nan = missing;
  missing.floats.erase(field->name());
  auto& longer = shape.floats.at(field->name());
  longer.shape[0] += 1;
  longer.values.resize(longer.values.size() + field->components());
  nan.floats.at(field->name()).values.back() = std::numeric_limits<double>::quiet_NaN();
  if (!expect_refusal(session, report, "missing_input", std::move(missing), v1::Error::BAD_MESSAGE)) return;
  if (!expect_refusal(session, report, "bad_shape", std::move(shape), v1::Error::BAD_MESSAGE)) return;
  (void)expect_refusal(session, report, "not_finite", std::move(nan), v1::Error::NOT_FINITE, field->name());
}

void check_refusals(const Trial& trial, Report& report) {
  play(trial, report, "refusals", {"refusals", "missing_input", "bad_shape", "not_finite", "wrong_run"},
       [&](Session& session) -> Result<void> {
         DROGUE_TRY(go_to(session, trial, ProtocolState::iterated));
         refuse_inputs(session, trial, report);
         wire::Message foreign = iterate(trial, 1, 2);
         foreign.envelope.set_run_id("another run");
         (void)expect_refusal(session, report, "wrong_run", std::move(foreign), v1::Error::BAD_MESSAGE);
         const auto got = ask_for(session, iterate(trial, 1, 2), Body::kIterated);
         if (!got) return got.error();
         DROGUE_TRY(same(trial.record.answers[0][1], *got));
         const auto committed = ask_for(session, commit(1), Body::kDone);
         return committed ? same_step(session, trial, 2) : committed.error();
       });
}

/// A request, answered; the same again; the same answer again.
Result<wire::Message> ask_twice(Session& session, wire::Message request, Body::BodyCase answer) {
  const std::string what(participant::name(request.envelope.body_case()));
  auto first = ask_for(session, std::move(request), answer);
  if (!first) return first;
  DROGUE_TRY(session.repeat());
  const auto second = session.receive(Seconds(session.deadline()));
  if (!second) return peer_error("{}, repeated: {}", what, second.error().message);
  if (const auto equal = same(*first, *second); !equal)
    return peer_error("{}, repeated: {}", what, equal.error().message);
  return first;
}

/// The repetition arrives before the answer, or just after it: one answer, or twice the same.
Result<wire::Message> ask_twice_at_once(Session& session, wire::Message request) {
  if (const auto sent = session.send(std::move(request)); !sent) return sent.error();
  DROGUE_TRY(session.repeat());
  auto first = session.receive(Seconds(session.deadline()));
  if (!first) return first;
  if (const auto second = session.receive(second_answer))
    if (const auto equal = same(*first, *second); !equal)
      return peer_error("two answers to one request: {}", equal.error().message);
  return first;
}

void check_repetitions(const Trial& trial, Report& report) {
  play(trial, report, "repeat", {"repeat"}, [&](Session& session) -> Result<void> {
    if (const auto said = hello(session); !said) return said.error();
    const std::vector<std::pair<wire::Message, Body::BodyCase>> requests{
        {configure(trial, session.folder()), Body::kDone},
        {initialize(), Body::kInitialized},
        {begin_step(trial, 1), Body::kDone},
        {iterate(trial, 1, 1), Body::kIterated}};
    for (const auto& [request, answer] : requests)
      if (const auto got = ask_twice(session, request, answer); !got) return got.error();
    const auto got = ask_twice_at_once(session, iterate(trial, 1, 2));
    if (!got) return got.error();
    DROGUE_TRY(same(trial.record.answers[0][1], *got));
    const auto committed = ask_twice(session, commit(1), Body::kDone);
    return committed ? same_step(session, trial, 2) : committed.error();
  });
}

} // namespace

void check_requests(const Trial& trial, Report& report) {
  check_again(trial, report);
  check_pause(trial, report);
  check_wrong_states(trial, report);
  check_refusals(trial, report);
  check_repetitions(trial, report);
}

} // namespace drogue::coupler::conform
