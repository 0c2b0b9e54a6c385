// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/launcher/peer.hpp"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <cstring>

#include <spdlog/spdlog.h>
#include <unistd.h>

namespace drogue::launcher {
namespace {

using std::chrono::steady_clock;

std::atomic<bool> interrupted_flag{false};
constexpr auto send_deadline = std::chrono::seconds(10);

steady_clock::time_point after(Seconds deadline) {
  return steady_clock::now() + std::chrono::duration_cast<steady_clock::duration>(deadline);
}

/// Of the socket of the coupler's children, as far as the system allows [bytes].
constexpr int local_buffer = 4 << 20;
/// Signs of life of connections from elsewhere.
constexpr int heartbeat_interval = 10000, heartbeat_deadline = 60000; // ms

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

std::string Peer::text() const {
  return process ? fmt::format("{} (pid {})", name, process->pid()) : name + " (started by hand)";
}

void Hub::interrupt() noexcept {
  interrupted_flag = true;
}
bool Hub::interrupted() noexcept {
  return interrupted_flag;
}

Result<std::unique_ptr<Hub>> Hub::create(std::string run_id, const Door& door, Witness* witness) {
  std::unique_ptr<Hub> hub(new Hub(std::move(run_id), witness));
  DROGUE_TRY(hub->open(door));
  return hub;
}

Result<void> Hub::open(const Door& door) {
  // A short path of our own: ipc paths hold at most 107 bytes, and nobody else may enter the folder.
  std::string folder = (std::filesystem::temp_directory_path() / "drogue-XXXXXX").string();
  if (!mkdtemp(folder.data())) return internal_error("cannot make a folder for the socket in {}", folder);
  socket_folder_ = folder;
  endpoint_ = fmt::format("ipc://{}/coupler", folder);
  try {
    router_ = zmq::socket_t(context_, zmq::socket_type::router);
    wire::prepare(router_);
    router_.set(zmq::sockopt::router_mandatory, true); // unroutable messages are errors, not dropped
    router_.set(zmq::sockopt::sndbuf, local_buffer);
    router_.set(zmq::sockopt::rcvbuf, local_buffer);
    router_.bind(endpoint_);
  } catch (const zmq::error_t& e) {
    return internal_error("cannot listen at {}: {}", endpoint_, e.what());
  }
  return door.endpoint.empty() ? Result<void>() : open_door(door);
}

/// A second address of the same socket: what is set from here on concerns connections to it alone.
Result<void> Hub::open_door(const Door& door) {
  if (!door.key && !keys::stays_on_this_machine(door.endpoint))
    return config_error("{} can be reached from other machines: it needs a key", door.endpoint);
  has_keys_ = door.key.has_value();
  if (has_keys_) DROGUE_TRY(authenticator_.open(context_, door.allowed));
  try {
    if (zmq_socket_monitor(router_.handle(), "inproc://connections", ZMQ_EVENT_DISCONNECTED) != 0)
      return internal_error("cannot watch connections: {}", zmq_strerror(zmq_errno()));
    monitor_ = zmq::socket_t(context_, zmq::socket_type::pair);
    monitor_.connect("inproc://connections");
    router_.set(zmq::sockopt::sndbuf, -1); // TCP finds the right size by itself
    router_.set(zmq::sockopt::rcvbuf, -1);
    router_.set(zmq::sockopt::heartbeat_ivl, heartbeat_interval);
    router_.set(zmq::sockopt::heartbeat_timeout, heartbeat_deadline);
    if (has_keys_) {
      router_.set(zmq::sockopt::zap_domain, "drogue");
      router_.set(zmq::sockopt::curve_server, true);
      router_.set(zmq::sockopt::curve_secretkey, door.key->secret_half);
    }
    router_.bind(door.endpoint);
    door_endpoint_ = router_.get(zmq::sockopt::last_endpoint);
  } catch (const zmq::error_t& e) {
    return config_error("cannot listen at {}: {}", door.endpoint, e.what());
  }
  return {};
}

Hub::~Hub() {
  peers_.clear(); // kills whatever is left
  if (monitor_) zmq_socket_monitor(router_.handle(), nullptr, 0);
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

Peer* Hub::expect(const std::string& name) {
  peers_.push_back(std::make_unique<Peer>());
  peers_.back()->name = name;
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
  if (const auto sent = send(peer, std::move(request), send_deadline); !sent) {
    DROGUE_TRY(check_alive());
    return Error{ErrorKind::peer, fmt::format("{}: {}", peer.name, sent.error().message), true};
  }
  return {};
}

Result<void> Hub::send(Peer& peer, wire::Message message, std::chrono::milliseconds deadline) {
  wire::Frames frames = wire::encode(std::move(message));
  if (witness_) DROGUE_TRY(witness_->sent(peer.name, frames));
  return wire::send(router_, peer.name, frames, deadline);
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
  if (has_keys_) items.push_back({authenticator_.socket().handle(), 0, ZMQ_POLLIN, 0});
  if (monitor_) items.push_back({monitor_.handle(), 0, ZMQ_POLLIN, 0});
  for (const auto& peer : peers_) {
    if (peer->process) items.push_back({nullptr, peer->process->pidfd(), ZMQ_POLLIN, 0});
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
  if (has_keys_) authenticator_.answer_all();
  for (bool more = true; more;) {
    const auto taken = take_one();
    if (!taken) return taken.error();
    more = *taken;
  }
  if (monitor_) follow_connections();
  if (interrupted()) return Error{ErrorKind::interrupted, "interrupted by a signal"};
  DROGUE_TRY(check_alive());
  return true;
}

/// What a stranger sends is ignored; what a participant sends must be right.
Result<bool> Hub::take_one() {
  auto received = wire::take(router_, true);
  if (!received) return received.error();
  if (!*received) return false;
  wire::Parcel parcel = std::move(**received);
  const auto it =
      std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) { return p->name == parcel.route; });
  const bool by_hand = it != peers_.end() && !(**it).process;
  if (it == peers_.end() || parcel.user != (by_hand && has_keys_ ? parcel.route : "")) {
    spdlog::warn("a message of somebody who calls himself \"{}\" does not belong here: ignored",
                 parcel.route);
    return true;
  }
  Peer& peer = **it;
  auto message = wire::decode(parcel.frames);
  if (!message) return peer_error("from {}: {}", peer.name, message.error().message);
  const v1::Envelope& e = message->envelope;
  if (e.participant() != peer.name || e.run_id() != run_id_) {
    spdlog::warn("a message of participant \"{}\", run \"{}\" does not belong here: ignored", e.participant(),
                 e.run_id());
    return true;
  }
  if (witness_) DROGUE_TRY(witness_->received(peer.name, parcel.frames));
  if (e.has_hello() && peer.state == participant::ProtocolState::connected)
    DROGUE_TRY(hear_hello(peer, e.hello(), parcel.connection));
  else
    DROGUE_TRY(take(peer, std::move(*message)));
  return true;
}

Result<void> Hub::hear_hello(Peer& peer, const v1::Hello& hello, int connection) {
  peer.hello = hello;
  peer.state = participant::ProtocolState::greeted;
  peer.connection = connection;
  if (!peer.process) return {}; // its processes may be another machine's
  for (const std::int64_t pid : hello.pid()) {
    if (pid == peer.process->pid()) continue;
    if (auto rank = Watch::on(static_cast<pid_t>(pid))) peer.ranks.push_back(std::move(*rank));
  }
  return {};
}

Result<void> Hub::take(Peer& peer, wire::Message message) {
  const v1::Envelope& e = message.envelope;
  const bool again = e.has_hello() || (e.request_id() != 0 && e.request_id() <= peer.answered);
  if (again) {
    spdlog::warn("{} sent {} again: ignored", peer.name, participant::name(e.body_case()));
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

void Hub::follow_connections() {
  zmq::message_t event;
  while (monitor_.recv(event, zmq::recv_flags::dontwait)) {
    std::int32_t connection = -1; // after two bytes that say which event
    if (event.size() >= 2 + sizeof connection)
      std::memcpy(&connection, event.data<char>() + 2, sizeof connection);
    zmq::message_t address;
    (void)monitor_.recv(address, zmq::recv_flags::dontwait);
    for (const auto& peer : peers_)
      if (!peer->process && peer->connection == connection && connection >= 0) peer->disconnected = true;
  }
}

} // namespace drogue::launcher
