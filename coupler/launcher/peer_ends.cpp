// SPDX-License-Identifier: GPL-3.0-or-later
// How participants end: those that die, refuse or are late, and those that are told to.
#include <algorithm>
#include <thread>

#include <fmt/ranges.h>

#include "coupler/launcher/peer.hpp"

namespace drogue::launcher {
namespace {

using std::chrono::steady_clock;

constexpr std::size_t culprit_log_lines = 8;
/// After a process has ended, how long its last message may still be under way.
constexpr auto last_message_grace = std::chrono::milliseconds(200);

ErrorKind kind_of(v1::Error::Code code) {
  switch (code) {
  case v1::Error::CONFIGURATION:
  case v1::Error::UNSUPPORTED:
    return ErrorKind::config;
  case v1::Error::NUMERICAL:
  case v1::Error::NOT_FINITE:
    return ErrorKind::numerical;
  case v1::Error::INTERNAL:
    return ErrorKind::internal;
  default:
    return ErrorKind::peer;
  }
}

/// A participant that is gone; `retryable`: a new start may help.
Error lost(std::string message, bool retryable = true) {
  return {ErrorKind::peer, std::move(message), retryable};
}

/// Exit statuses by which a program says that another start would end in the same way: bad config, numerical
/// failure.
bool unfit(const Exit& exit) {
  return exit.status == static_cast<int>(ErrorKind::config) ||
         exit.status == static_cast<int>(ErrorKind::numerical);
}

/// "; the end of its log FILE: ...", or nothing for a participant that somebody else started.
std::string log_tail(const Peer& peer) {
  if (!peer.process) return "";
  const auto lines = last_lines(peer.log_file, culprit_log_lines);
  if (lines.empty()) return fmt::format("; (its log {} is empty)", peer.log_file.string());
  return fmt::format("; the end of its log {}:\n  | {}", peer.log_file.string(), fmt::join(lines, "\n  | "));
}

} // namespace

/// A process that ended although nobody told it to is an error, unless its last answer explains it. Ranks
/// come first: mpiexec only follows them.
Result<void> Hub::check_alive() {
  for (const auto& peer : peers_) {
    if (peer->answer) continue;
    if (peer->process)
      DROGUE_TRY(check_process(*peer));
    else if (peer->disconnected)
      return death(*peer, peer->text(), "closed its connection", true);
  }
  return {};
}

Result<void> Hub::check_process(Peer& peer) {
  const auto rank =
      std::find_if(peer.ranks.begin(), peer.ranks.end(), [](const Watch& watch) { return watch.ended(); });
  const bool rank_ended = rank != peer.ranks.end();
  if (!peer.process->poll() && !rank_ended) return {};
  DROGUE_TRY(take_last_words(peer));
  if (peer.answer) return {};
  if (interrupted()) return Error{ErrorKind::interrupted, "interrupted by a signal"};
  if (rank_ended)
    return death(peer, fmt::format("{} (pid {})", peer.name, rank->pid()), "is one of its ranks and ended",
                 true);
  const Exit& exit = *peer.process->poll();
  return death(peer, peer.text(), exit.text(), !unfit(exit));
}

Result<void> Hub::take_last_words(Peer& peer) {
  const auto end = steady_clock::now() + last_message_grace;
  while (!peer.answer && steady_clock::now() < end) {
    const auto taken = take_one();
    if (!taken) return taken.error();
    if (!*taken) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return {};
}

/// @pre the peer's answer is an Error
Error Hub::refusal(const Peer& peer) const {
  const v1::Error& error = peer.answer->envelope.error();
  return {kind_of(error.code()),
          fmt::format("{} refused {}: {}", peer.name, request_text(peer.request_body, peer.where),
                      error.message()),
          error.retryable() && kind_of(error.code()) == ErrorKind::numerical};
}

Error Hub::death(const Peer& peer, const std::string& who, const std::string& how, bool retryable) const {
  const std::string during = peer.state == participant::ProtocolState::connected ? "before it said Hello"
                             : peer.request != 0 ? "during " + request_text(peer.request_body, peer.where)
                                                 : "between two requests";
  return lost(fmt::format("{} {} {}{}", who, how, during, log_tail(peer)), retryable);
}

Error Hub::lateness(const Peer& peer, const std::string& what, Seconds deadline) const {
  const std::string last = peer.beat ? fmt::format("its last sign of life: {} (iteration {})",
                                                   peer.beat->phase(), peer.beat->inner_iteration())
                                     : std::string("it gave no sign of life");
  return lost(fmt::format("{} did not {} within {:g} s; {}{}", peer.text(), what, deadline.count(), last,
                          log_tail(peer)));
}

void Hub::close_all(Seconds deadline, const std::function<void(v1::Envelope&)>& body) {
  for (const auto& peer : peers_) {
    if ((peer->process && peer->process->poll()) || peer->disconnected ||
        peer->state == participant::ProtocolState::connected)
      continue;
    wire::Message message;
    message.envelope.set_run_id(run_id_);
    message.envelope.set_participant(peer->name);
    message.envelope.set_request_id(++last_request_);
    body(message.envelope);
    peer->request = last_request_;
    peer->answer.reset();
    (void)send(*peer, std::move(message), std::chrono::milliseconds(100));
  }
  const auto end = steady_clock::now() + std::chrono::duration_cast<steady_clock::duration>(deadline);
  for (const auto& peer : peers_) wait_for_end(*peer, end);
}

/// Of a process; of a participant that somebody else started, its answer, after which it ends by itself.
void Hub::wait_for_end(Peer& peer, steady_clock::time_point end) {
  if (peer.process) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - steady_clock::now());
    peer.overdue = !peer.process->wait(std::max(left, std::chrono::milliseconds(0)));
    return peer.process->kill_session();
  }
  const auto gone = [&] {
    return peer.answer || peer.disconnected || peer.state == participant::ProtocolState::connected;
  };
  while (!gone() && steady_clock::now() < end) {
    const auto taken = take_one();
    if (!taken || !*taken) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (monitor_) follow_connections();
  }
  peer.overdue = !gone();
}

Result<void> Hub::shut_down(Seconds deadline) {
  close_all(deadline, [](v1::Envelope& e) { e.mutable_shutdown(); });
  for (const auto& peer : peers_) {
    const std::optional<Exit>& exit = peer->process ? peer->process->poll() : std::optional<Exit>();
    const bool ended = !peer->overdue && (!peer->process || (exit && exit->clean()));
    if (!ended)
      return lost(fmt::format("{} {} after Shutdown (deadline {:g} s){}", peer->name,
                              peer->overdue || !exit ? "did not end" : exit->text(), deadline.count(),
                              log_tail(*peer)));
  }
  return {};
}

void Hub::abort(const std::string& reason) {
  const std::string without_log = reason.substr(0, reason.find('\n'));
  close_all(Seconds(0.5), [&](v1::Envelope& e) { e.mutable_abort()->set_reason(without_log); });
}

} // namespace drogue::launcher
