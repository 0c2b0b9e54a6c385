// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/launcher/peer.hpp"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <thread>

#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

namespace drogue::launcher {
namespace {

using std::chrono::steady_clock;

std::atomic<bool> interrupted_flag{false};
constexpr std::size_t culprit_log_lines = 8;
constexpr auto send_deadline = std::chrono::seconds(10);
/// After a process has ended, how long its last message may still be under way.
constexpr auto last_message_grace = std::chrono::milliseconds(200);

steady_clock::time_point after(Seconds deadline) {
  return steady_clock::now() + std::chrono::duration_cast<steady_clock::duration>(deadline);
}

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

std::string log_tail(const Peer& peer) {
  const auto lines = last_lines(peer.log_file, culprit_log_lines);
  if (lines.empty()) return fmt::format("(its log {} is empty)", peer.log_file.string());
  return fmt::format("the end of its log {}:\n  | {}", peer.log_file.string(), fmt::join(lines, "\n  | "));
}

} // namespace

std::string request_text(v1::Envelope::BodyCase body, const v1::Envelope& where) {
  std::string text(participant::name(body));
  if (where.step() > 0) text += fmt::format(" of step {}", where.step());
  if (where.iteration() > 0) text += fmt::format(", iteration {}", where.iteration());
  return text;
}

double Peer::peak_memory_mb() const {
  double sum = process ? launcher::peak_memory_mb(process->pid()) : 0;
  for (const Watch& rank : ranks) sum += launcher::peak_memory_mb(rank.pid());
  return sum;
}

void Hub::interrupt() noexcept {
  interrupted_flag = true;
}
bool Hub::interrupted() noexcept {
  return interrupted_flag;
}

Result<std::unique_ptr<Hub>> Hub::create(std::string run_id) {
  std::unique_ptr<Hub> hub(new Hub(std::move(run_id)));
  // A short path of our own: ipc paths hold at most 107 bytes, and nobody else may enter the folder.
  std::string folder = (std::filesystem::temp_directory_path() / "drogue-XXXXXX").string();
  if (!mkdtemp(folder.data())) return internal_error("cannot make a folder for the socket in {}", folder);
  hub->socket_folder_ = folder;
  try {
    hub->router_ = zmq::socket_t(hub->context_, zmq::socket_type::router);
    wire::prepare(hub->router_);
    hub->router_.set(zmq::sockopt::router_mandatory, true); // unroutable messages are errors, not dropped
    hub->endpoint_ = fmt::format("ipc://{}/coupler", folder);
    hub->router_.bind(hub->endpoint_);
  } catch (const zmq::error_t& e) {
    return internal_error("cannot listen at {}: {}", hub->endpoint_, e.what());
  }
  return hub;
}

Hub::~Hub() {
  peers_.clear(); // kills whatever is left
  router_.close();
  std::error_code ignored;
  if (!socket_folder_.empty()) std::filesystem::remove_all(socket_folder_, ignored);
}

Result<Peer*> Hub::start(const std::string& name, const Command& command) {
  auto peer = std::make_unique<Peer>();
  peer->name = name;
  peer->log_file = command.log_file;
  auto process = Process::start(command);
  if (!process) return Error{process.error().kind, fmt::format("{}: {}", name, process.error().message)};
  peer->process = std::move(*process);
  peer->asked_at = steady_clock::now();
  peers_.push_back(std::move(peer));
  return peers_.back().get();
}

Result<void> Hub::await_hello(Peer& peer, Seconds deadline) {
  const auto end = after(deadline);
  while (peer.state == participant::ProtocolState::connected) {
    const auto turned = turn(end);
    if (!turned) return turned.error();
    if (!*turned) return lateness(peer, "say Hello", deadline);
  }
  return {};
}

Result<void> Hub::post(Peer& peer, wire::Message request) {
  v1::Envelope& e = request.envelope;
  if (!participant::next_state(peer.state, e.body_case()))
    return internal_error("the coupler wanted to send {} to {} in state {}", participant::name(e.body_case()),
                          peer.name, participant::name(peer.state));
  e.set_run_id(run_id_);
  e.set_participant(peer.name);
  e.set_request_id(++last_request_);
  peer.request = last_request_;
  peer.request_body = e.body_case();
  peer.where.set_step(e.step());
  peer.where.set_iteration(e.iteration());
  peer.beat.reset();
  peer.answer.reset();
  peer.asked_at = steady_clock::now();
  if (const auto sent = wire::send(router_, peer.name, request, send_deadline); !sent) {
    DROGUE_TRY(check_alive());
    return lost(fmt::format("{}: {}", peer.name, sent.error().message));
  }
  return {};
}

Result<wire::Message> Hub::await(Peer& peer, Seconds deadline) {
  const auto end = after(deadline);
  while (!peer.answer) {
    const auto turned = turn(end);
    if (!turned) return turned.error();
    if (!*turned) return lateness(peer, "answer " + request_text(peer.request_body, peer.where), deadline);
    for (const auto& other : peers_) // the first error wins, whoever is waited for
      if (other.get() != &peer && other->answer && other->answer->envelope.has_error())
        return refusal(*other);
  }
  peer.request = 0;
  if (peer.answer->envelope.has_error()) {
    Error error = refusal(peer);
    peer.answer.reset();
    return error;
  }
  wire::Message answer = std::move(*peer.answer);
  peer.answer.reset();
  peer.state = *participant::next_state(peer.state, peer.request_body);
  return answer;
}

Result<wire::Message> Hub::ask(Peer& peer, wire::Message request, Seconds deadline) {
  DROGUE_TRY(post(peer, std::move(request)));
  return await(peer, deadline);
}

Result<bool> Hub::turn(steady_clock::time_point deadline) {
  std::vector<zmq::pollitem_t> items{{router_.handle(), 0, ZMQ_POLLIN, 0}};
  for (const auto& peer : peers_) {
    items.push_back({nullptr, peer->process->pidfd(), ZMQ_POLLIN, 0});
    for (const Watch& rank : peer->ranks) items.push_back({nullptr, rank.pidfd(), ZMQ_POLLIN, 0});
  }
  // Short waits, so that a signal is noticed soon.
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - steady_clock::now());
  if (left.count() <= 0) return false;
  try {
    zmq::poll(items.data(), items.size(), std::min(left, std::chrono::milliseconds(250)));
  } catch (const zmq::error_t& e) {
    if (e.num() != EINTR) return internal_error("cannot poll: {}", e.what());
  }
  while (true) {
    auto received = wire::receive(router_, true);
    if (!received) return received.error();
    if (!*received) break;
    DROGUE_TRY(take(std::move((**received).message)));
  }
  if (interrupted()) return Error{ErrorKind::interrupted, "interrupted by a signal"};
  DROGUE_TRY(check_alive());
  return true;
}

Result<void> Hub::take(wire::Message message) {
  const v1::Envelope& e = message.envelope;
  const auto it =
      std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) { return p->name == e.participant(); });
  if (it == peers_.end() || e.run_id() != run_id_) {
    spdlog::warn("a message of participant \"{}\", run \"{}\" does not belong here: ignored", e.participant(),
                 e.run_id());
    return {};
  }
  Peer& peer = **it;
  const bool again = e.has_hello() ? peer.state != participant::ProtocolState::connected
                                   : e.request_id() != 0 && e.request_id() <= peer.answered;
  if (again) {
    spdlog::warn("{} sent {} again: ignored", peer.name, participant::name(e.body_case()));
  } else if (e.has_hello()) {
    peer.hello = e.hello();
    peer.state = participant::ProtocolState::greeted;
    for (const std::int64_t pid : e.hello().pid()) {
      if (pid == peer.process->pid()) continue;
      if (auto rank = Watch::on(static_cast<pid_t>(pid))) peer.ranks.push_back(std::move(*rank));
    }
  } else if (e.has_beat()) {
    peer.beat = e.beat();
  } else if (peer.request != 0 && e.request_id() == peer.request) {
    peer.busy_seconds += Seconds(steady_clock::now() - peer.asked_at).count();
    peer.answered = peer.request;
    peer.answer = std::move(message);
  } else {
    return peer_error("{} answered request {} while request {} was outstanding", peer.name, e.request_id(),
                      peer.request);
  }
  return {};
}

/// A process that ended although nobody told it to is an error, unless its last answer explains it. Ranks
/// come first: mpiexec only follows them.
Result<void> Hub::check_alive() {
  for (const auto& peer : peers_) {
    if (peer->answer) continue;
    const auto rank = std::find_if(peer->ranks.begin(), peer->ranks.end(),
                                   [](const Watch& watch) { return watch.ended(); });
    const bool rank_ended = rank != peer->ranks.end();
    if (!peer->process->poll() && !rank_ended) continue;
    DROGUE_TRY(take_last_words(*peer));
    if (peer->answer) continue;
    if (interrupted()) return Error{ErrorKind::interrupted, "interrupted by a signal"};
    if (rank_ended) return death(*peer, rank->pid(), "is one of its ranks and ended", true);
    const Exit& exit = *peer->process->poll();
    return death(*peer, peer->process->pid(), exit.text(), !unfit(exit));
  }
  return {};
}

Result<void> Hub::take_last_words(Peer& peer) {
  const auto end = steady_clock::now() + last_message_grace;
  while (!peer.answer && steady_clock::now() < end) {
    auto received = wire::receive(router_, true);
    if (!received) return received.error();
    if (*received)
      DROGUE_TRY(take(std::move((**received).message)));
    else
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
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

Error Hub::death(const Peer& peer, pid_t pid, const std::string& how, bool retryable) const {
  const std::string during = peer.state == participant::ProtocolState::connected ? "before it said Hello"
                             : peer.request != 0 ? "during " + request_text(peer.request_body, peer.where)
                                                 : "between two requests";
  return lost(fmt::format("{} (pid {}) {} {}; {}", peer.name, pid, how, during, log_tail(peer)), retryable);
}

Error Hub::lateness(const Peer& peer, const std::string& what, Seconds deadline) const {
  const std::string last = peer.beat ? fmt::format("its last sign of life: {} (iteration {})",
                                                   peer.beat->phase(), peer.beat->inner_iteration())
                                     : std::string("it gave no sign of life");
  return lost(fmt::format("{} (pid {}) did not {} within {:g} s; {}; {}", peer.name, peer.process->pid(),
                          what, deadline.count(), last, log_tail(peer)));
}

void Hub::close_all(Seconds deadline, const std::function<void(v1::Envelope&)>& body) {
  for (const auto& peer : peers_) {
    if (peer->process->poll() || peer->state == participant::ProtocolState::connected) continue;
    wire::Message message;
    message.envelope.set_run_id(run_id_);
    message.envelope.set_participant(peer->name);
    message.envelope.set_request_id(++last_request_);
    body(message.envelope);
    (void)wire::send(router_, peer->name, message, std::chrono::milliseconds(100));
  }
  const auto end = after(deadline);
  for (const auto& peer : peers_) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - steady_clock::now());
    peer->overdue = !peer->process->wait(std::max(left, std::chrono::milliseconds(0)));
    peer->process->kill_session();
  }
}

Result<void> Hub::shut_down(Seconds deadline) {
  close_all(deadline, [](v1::Envelope& e) { e.mutable_shutdown(); });
  for (const auto& peer : peers_)
    if (const auto& exit = peer->process->poll(); peer->overdue || !exit || !exit->clean())
      return lost(fmt::format("{} {} after Shutdown (deadline {:g} s); {}", peer->name,
                              peer->overdue || !exit ? "did not end" : exit->text(), deadline.count(),
                              log_tail(*peer)));
  return {};
}

void Hub::abort(const std::string& reason) {
  const std::string without_log = reason.substr(0, reason.find('\n'));
  close_all(Seconds(0.5), [&](v1::Envelope& e) { e.mutable_abort()->set_reason(without_log); });
}

} // namespace drogue::launcher
