// SPDX-License-Identifier: GPL-3.0-or-later
#include "participant/cpp/transport.hpp"

#include <array>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <span>

#include <spdlog/spdlog.h>

#include "common/base/interrupt.hpp"
#include "participant/cpp/keys.hpp"
#include "participant/cpp/protocol_state.hpp"

namespace drogue::participant {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::chrono::milliseconds beat_interval{1000};
/// How soon a wait notices a signal.
constexpr auto interrupt_interval = std::chrono::milliseconds(100);
/// How long a solver that is in the middle of its work may go on after the coupler is gone.
constexpr auto grace_without_coupler = std::chrono::seconds(10);
constexpr int last_answer_linger = 2000; // ms
/// Of the sockets between processes of one machine, as far as the system allows: the default of 200 KB makes
/// a large array change hands hundreds of times [bytes].
constexpr int local_buffer = 4 << 20;
constexpr auto send_deadline = std::chrono::seconds(30);

constexpr int connection_events = ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED |
                                  ZMQ_EVENT_HANDSHAKE_FAILED_AUTH | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL;

struct Progress {
  std::atomic<const char*> phase{""};
  std::atomic<std::uint32_t> inner_iteration{0};
  std::atomic<double> inner_residual{0};
};
Progress& progress() {
  static Progress p;
  return p;
}

} // namespace

void report_progress(const char* phase, std::uint32_t inner_iteration, double inner_residual) {
  progress().phase = phase;
  progress().inner_iteration = inner_iteration;
  progress().inner_residual = inner_residual;
}

Transport::Transport(const ServeOptions& options)
    : endpoint_(options.endpoint),
      participant_(options.participant),
      run_id_(options.run_id),
      key_file_(options.key_file),
      coupler_key_(options.coupler_key) {}

Transport::~Transport() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(stop_mutex_);
    stop_ = true;
  }
  stopped_.notify_all();
  thread_.join(); // it never waits for the peer but in a send, which has a deadline
  // ZeroMQ may still hold the last answer: it gets a moment to leave, in the background, while the coupler is
  // there.
  socket_.set(zmq::sockopt::linger, lost_.empty() ? last_answer_linger : 0);
}

Result<void> Transport::set_keys() {
  if (coupler_key_.empty()) {
    if (keys::stays_on_this_machine(endpoint_)) return {};
    return config_error("{} is not on this machine, and there are no keys: set DROGUE_COUPLER_KEY to the "
                        "coupler's public key and DROGUE_KEY to the file of this participant's own "
                        "(coupler keygen makes them)",
                        endpoint_);
  }
  if (!keys::is_key(coupler_key_)) return config_error("DROGUE_COUPLER_KEY is not a key of 40 characters");
  const auto own = keys::read_pair(key_file_);
  if (!own) return Error{ErrorKind::config, "DROGUE_KEY: " + own.error().message};
  keys::use(socket_, *own, coupler_key_);
  return {};
}

void Transport::connect() {
  monitor_ = zmq::socket_t(context_, zmq::socket_type::pair);
  monitor_.connect("inproc://events");
  socket_.connect(endpoint_);
}

Result<void> Transport::start() {
  try {
    socket_ = zmq::socket_t(context_, zmq::socket_type::dealer);
    wire::prepare(socket_);
    socket_.set(zmq::sockopt::routing_id, participant_);
    if (endpoint_.rfind("ipc://", 0) == 0) { // TCP finds the right size by itself
      socket_.set(zmq::sockopt::sndbuf, local_buffer);
      socket_.set(zmq::sockopt::rcvbuf, local_buffer);
    }
    DROGUE_TRY(set_keys());
    if (zmq_socket_monitor(socket_.handle(), "inproc://events", connection_events) != 0)
      return internal_error("cannot watch the connection: {}", zmq_strerror(zmq_errno()));
    connect();
  } catch (const zmq::error_t& e) {
    return peer_error("cannot connect to the coupler at \"{}\": {}", endpoint_, e.what());
  }
  thread_ = std::thread([this] { stand_in(); });
  return {};
}

Result<wire::Message> Transport::next_request(std::chrono::seconds deadline) {
  const auto end = steady_clock::now() + deadline;
  const std::lock_guard lock(mutex_);
  while (incoming_.empty() && lost_.empty() && !interrupted()) {
    if (steady_clock::now() >= end)
      return peer_error("{}: the coupler at {} sent nothing for {} s", participant_, endpoint_,
                        deadline.count());
    turn(interrupt_interval);
  }
  if (interrupted())
    return Error{ErrorKind::interrupted, fmt::format("{}: interrupted by a signal", participant_)};
  if (incoming_.empty()) return peer_error("{}: {}", participant_, lost_);
  wire::Message request = std::move(incoming_.front());
  incoming_.pop_front();
  return request;
}

void Transport::post(wire::Message message) {
  message.envelope.set_run_id(run_id_);
  message.envelope.set_participant(participant_);
  const std::uint64_t request = message.envelope.request_id();
  wire::Frames frames = wire::encode(std::move(message));
  const std::lock_guard lock(mutex_);
  if (const auto sent = wire::send(socket_, "", frames, send_deadline); !sent) lose(sent.error().message);
  if (request == 0) return;
  working_on_ = 0;
  last_answered_ = request;
  last_answer_ = std::move(frames);
}

void Transport::stand_in() {
  sigset_t for_the_program; // signals go to the other threads
  sigemptyset(&for_the_program);
  sigaddset(&for_the_program, SIGINT);
  sigaddset(&for_the_program, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &for_the_program, nullptr);
  std::unique_lock until_stop(stop_mutex_);
  while (!stopped_.wait_for(until_stop, beat_interval / 2, [this] { return stop_; })) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock.owns_lock()) continue; // the solver's thread is at the socket
    turn(milliseconds(0));
    beat();
    leave_if_abandoned();
  }
}

/// Waits for a message and takes it; a signal ends the wait early.
void Transport::turn(milliseconds wait) {
  std::array<zmq::pollitem_t, 2> items{
      {{socket_.handle(), 0, ZMQ_POLLIN, 0}, {monitor_.handle(), 0, ZMQ_POLLIN, 0}}};
  try {
    zmq::poll(items.data(), items.size(), wait);
  } catch (const zmq::error_t& e) {
    if (e.num() != EINTR) lose(fmt::format("cannot wait for the coupler: {}", e.what()));
    return;
  }
  if ((items[0].revents & ZMQ_POLLIN) != 0) {
    auto received = wire::receive(socket_, false);
    if (!received)
      lose(received.error().message);
    else if (*received)
      take(std::move((**received).message));
  }
  if ((items[1].revents & ZMQ_POLLIN) != 0) follow_connection();
}

/// A request seen before is answered from the cache (or ignored while the solver works on it); every other
/// one goes to the solver.
void Transport::take(wire::Message request) {
  const std::uint64_t id = request.envelope.request_id();
  if (id != 0 && id == working_on_) return;
  if (id != 0 && id == last_answered_) {
    if (const auto sent = wire::send(socket_, "", last_answer_, send_deadline); !sent)
      lose(sent.error().message);
    return;
  }
  working_on_ = id;
  last_request_.envelope = request.envelope;
  last_request_.envelope.clear_array();
  report_progress("");
  last_beat_ = steady_clock::now();
  incoming_.push_back(std::move(request));
}

void Transport::beat() {
  if (working_on_ == 0 || steady_clock::now() - last_beat_ < beat_interval) return;
  last_beat_ = steady_clock::now();
  wire::Message message;
  message.envelope.set_run_id(run_id_);
  message.envelope.set_participant(participant_);
  message.envelope.set_step(last_request_.envelope.step());
  message.envelope.set_iteration(last_request_.envelope.iteration());
  message.envelope.set_attempt(last_request_.envelope.attempt());
  v1::Beat& b = *message.envelope.mutable_beat();
  b.set_phase(progress().phase.load());
  b.set_inner_iteration(progress().inner_iteration);
  b.set_inner_residual(progress().inner_residual);
  (void)wire::send(socket_, "", message, send_deadline); // a lost beat is harmless: the next one follows
}

void Transport::follow_connection() {
  zmq::message_t event;
  while (monitor_.recv(event, zmq::recv_flags::dontwait)) {
    std::uint16_t kind = 0;
    if (event.size() >= sizeof kind) std::memcpy(&kind, event.data(), sizeof kind);
    zmq::message_t address;
    (void)monitor_.recv(address, zmq::recv_flags::dontwait);
    if (kind == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) connected_ = true;
    if (kind == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH) lose("the coupler does not allow this participant's key");
    if (kind == ZMQ_EVENT_DISCONNECTED || kind == ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL)
      lose(connected_ ? "the coupler closed the connection"
                      : "the coupler closed the connection before it was set up: do the keys fit?");
  }
}

void Transport::lose(const std::string& why) {
  if (!lost_.empty()) return;
  lost_ = why;
  lost_at_ = steady_clock::now();
}

/// Without a coupler nobody wants the result: a solver deep in a long solve must not live on as an orphan.
/// Nothing written is lost, as every result file is renamed into place when it is complete.
void Transport::leave_if_abandoned() const {
  if (lost_at_ == steady_clock::time_point{} || steady_clock::now() - lost_at_ < grace_without_coupler)
    return;
  spdlog::error("the coupler is gone: leaving in the middle of the work");
  std::_Exit(static_cast<int>(ErrorKind::peer));
}

} // namespace drogue::participant
