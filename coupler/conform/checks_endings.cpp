// SPDX-License-Identifier: GPL-3.0-or-later
// Ends, in order and not.
#include <array>

#include "common/base/hash.hpp"
#include "coupler/conform/script.hpp"

namespace drogue::coupler::conform {
namespace {

using participant::ProtocolState;
using Body = v1::Envelope;

constexpr std::array states{ProtocolState::greeted, ProtocolState::configured, ProtocolState::ready,
                            ProtocolState::in_step, ProtocolState::iterated};
constexpr int lost_status = static_cast<int>(ErrorKind::peer);
/// The protocol gives a participant ten seconds, and its end may take a moment.
constexpr Seconds death_deadline{12};
constexpr int short_silence = 2; ///< seconds

std::string label(const char* what, ProtocolState state) {
  std::string name(participant::name(state));
  for (char& c : name) c = static_cast<char>(std::tolower(c));
  return fmt::format("{}_{}", what, name);
}

Result<void> with_state(ProtocolState state, const Result<void>& outcome) {
  if (outcome) return {};
  return peer_error("in state {}: {}", participant::name(state), outcome.error().message);
}

/// It ended by itself with a status that `fits`.
template <class Fits>
Result<void> ended(Session& session, Seconds deadline, Fits fits, const char* expected) {
  const auto exit = session.end(deadline);
  if (!exit) return exit.error();
  if (exit->signal == 0 && fits(exit->status)) return {};
  return peer_error("it {}; {} expected", exit->text(), expected);
}

void check_shutdown(const Trial& trial, Report& report, ProtocolState state) {
  play(trial, report, label("shutdown", state), {"shutdown", "orphans"},
       [&](Session& session) -> Result<void> {
         DROGUE_TRY(with_state(state, go_to(session, trial, state)));
         if (const auto got = ask_for(session, shutdown(), Body::kDone); !got)
           return with_state(state, got.error());
         const auto outcome = ended(
             session, end_deadline, [](int status) { return status == 0; }, "status 0");
         if (outcome && state == ProtocolState::ready) check_orphans(session.greeting(), report);
         return with_state(state, outcome);
       });
}

void check_abort(const Trial& trial, Report& report, ProtocolState state) {
  play(trial, report, label("abort", state), {"abort"}, [&](Session& session) -> Result<void> {
    DROGUE_TRY(with_state(state, go_to(session, trial, state)));
    if (const auto sent = session.send(abort_run()); !sent) return with_state(state, sent.error());
    return with_state(
        state, ended(
                   session, end_deadline, [](int status) { return status != 0; }, "another status than 0"));
  });
}

void check_death(const Trial& trial, Report& report, ProtocolState state) {
  play(trial, report, label("death", state), {"coupler_death"}, [&](Session& session) -> Result<void> {
    DROGUE_TRY(with_state(state, go_to(session, trial, state)));
    session.disappear();
    return with_state(
        state, ended(
                   session, death_deadline, [](int status) { return status == lost_status; }, "status 4"));
  });
}

void check_silence(const Trial& trial, Report& report) {
  const auto body = [&](Session& session) -> Result<void> {
    if (const auto said = hello(session); !said) return said.error();
    return ended(
        session, Seconds(short_silence) + end_deadline, [](int status) { return status == lost_status; },
        "status 4");
  };
  play(trial, report, "silence", {"silence"}, body, short_silence);
}

void check_version(const Trial& trial, Report& report) {
  play(trial, report, "version", {"version_refused"}, [&](Session& session) -> Result<void> {
    DROGUE_TRY(go_to(session, trial, ProtocolState::greeted));
    wire::Message request = configure(trial, session.folder());
    request.envelope.mutable_configure()->set_version(999);
    if (const auto got = ask_for_error(session, std::move(request), v1::Error::UNSUPPORTED); !got)
      return got.error();
    return ended(
        session, end_deadline, [](int status) { return status == static_cast<int>(ErrorKind::config); },
        "status 2");
  });
}

/// Frames of a message that looks like the next Iterate but for one thing.
struct Malformed {
  const char* name;
  std::vector<std::string> frames;
};

std::vector<Malformed> malformed(const Trial& trial, const std::string& run_id) {
  const std::string magic("DRGW\x01", 5);
  wire::Message request = iterate(trial, 1, 1);
  v1::Envelope& e = request.envelope;
  e.set_run_id(run_id);
  e.set_participant(trial.subject.role);
  e.set_request_id(1000);
  std::vector<std::string> arrays;
  for (const auto& [name, array] : request.floats) {
    v1::ArrayHeader& header = *e.add_array();
    header.set_name(name);
    header.set_type(v1::ArrayHeader::FLOAT64);
    for (const std::uint64_t extent : array.shape) header.add_shape(extent);
    header.set_byte_length(8 * array.values.size());
    header.set_crc32(crc32(std::as_bytes(std::span(array.values))));
    arrays.emplace_back(reinterpret_cast<const char*>(array.values.data()), 8 * array.values.size());
  }
  const std::string whole = e.SerializeAsString();
  std::vector<Malformed> list{{"another magic", {"HTTP/", whole}},
                              {"an envelope cut short", {magic, whole.substr(0, whole.size() - 3)}},
                              {"one frame alone", {magic}}};
  for (Malformed& m : list)
    if (m.frames.size() > 1) m.frames.insert(m.frames.end(), arrays.begin(), arrays.end());
  if (arrays.empty()) return list;
  Malformed altered{"a wrong checksum", {magic, whole}}, cut{"an array cut short", {magic, whole}};
  altered.frames.insert(altered.frames.end(), arrays.begin(), arrays.end());
  altered.frames.back()[0] = static_cast<char>(altered.frames.back()[0] ^ 1);
  cut.frames.insert(cut.frames.end(), arrays.begin(), arrays.end());
  cut.frames.back().resize(cut.frames.back().size() - 8);
  list.push_back(std::move(altered));
  list.push_back(std::move(cut));
  return list;
}

/// An Error, or an end by itself with another status than 0: both say that something is wrong.
void check_malformed(const Trial& trial, Report& report) {
  for (std::size_t i = 0; i < malformed(trial, "").size(); ++i)
    play(trial, report, fmt::format("malformed_{}", i + 1), {"malformed"},
         [&](Session& session) -> Result<void> {
           const Malformed m = malformed(trial, session.run_id())[i];
           DROGUE_TRY(go_to(session, trial, ProtocolState::in_step));
           DROGUE_TRY(session.send_frames(m.frames));
           const auto got = session.receive(Seconds(session.deadline()));
           if (got && got->envelope.has_error()) return {};
           if (got) return peer_error("{}: answered with {}", m.name, answer_text(*got));
           const auto outcome = ended(
               session, end_deadline, [](int status) { return status != 0; }, "another status than 0");
           return outcome ? outcome : peer_error("{}: {}", m.name, outcome.error().message);
         });
}

} // namespace

void check_endings(const Trial& trial, Report& report) {
  check_version(trial, report);
  check_malformed(trial, report);
  for (const ProtocolState state : states) {
    check_shutdown(trial, report, state);
    check_abort(trial, report, state);
  }
  for (const ProtocolState state : {ProtocolState::greeted, ProtocolState::ready, ProtocolState::iterated})
    check_death(trial, report, state);
  check_silence(trial, report);
}

} // namespace drogue::coupler::conform
