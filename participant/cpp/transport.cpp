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

constexpr auto beat_interval = std::chrono::seconds(1);
/// How soon a wait notices a signal.
constexpr auto interrupt_interval = std::chrono::milliseconds(100);
/// How long a solver that is in the middle of its work may go on after the coupler is gone.
constexpr auto grace_without_coupler = std::chrono::seconds(10);
constexpr int last_answer_linger = 2000; // ms
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

/// Waits for messages, half a beat at most; a signal ends the wait early.
Result<void> wait_for(std::span<zmq::pollitem_t> items) {
  try {
    zmq::poll(items.data(), items.size(), milliseconds(beat_interval) / 2);
  } catch (const zmq::error_t& e) {
    for (zmq::pollitem_t& item : items) item.revents = 0;
    if (e.num() != EINTR) return internal_error("cannot wait for the coupler: {}", e.what());
  }
  return {};
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
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_in_.send(zmq::message_t(), zmq::send_flags::dontwait);
  thread_.join(); // it never waits for the peer: its polls end within a beat, its sends at their deadline
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
  wake_out_ = zmq::socket_t(context_, zmq::socket_type::pair);
  wake_out_.bind("inproc://wake");
  wake_in_ = zmq::socket_t(context_, zmq::socket_type::pair);
  wake_in_.connect("inproc://wake");
  socket_.connect(endpoint_);
}

Result<void> Transport::start() {
  try {
    socket_ = zmq::socket_t(context_, zmq::socket_type::dealer);
    wire::prepare(socket_);
    socket_.set(zmq::sockopt::routing_id, participant_);
    DROGUE_TRY(set_keys());
    if (zmq_socket_monitor(socket_.handle(), "inproc://events", connection_events) != 0)
      return internal_error("cannot watch the connection: {}", zmq_strerror(zmq_errno()));
    connect();
  } catch (const zmq::error_t& e) {
    return peer_error("cannot connect to the coupler at \"{}\": {}", endpoint_, e.what());
  }
  thread_ = std::thread([this] { loop(); });
  return {};
}

Result<wire::Message> Transport::next_request(std::chrono::seconds deadline) {
  const auto end = std::chrono::steady_clock::now() + deadline;
  std::unique_lock lock(mutex_);
  const auto ready = [this] { return !incoming_.empty() || !lost_.empty() || interrupted(); };
  while (!incoming_ready_.wait_for(lock, interrupt_interval, ready))
    if (std::chrono::steady_clock::now() >= end)
      return peer_error("{}: the coupler at {} sent nothing for {} s", participant_, endpoint_,
                        deadline.count());
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
  enqueue({request, wire::encode(std::move(message))});
  wake_in_.send(zmq::message_t(), zmq::send_flags::dontwait);
}

void Transport::enqueue(Outgoing outgoing) {
  const std::lock_guard lock(mutex_);
  outgoing_.push_back(std::move(outgoing));
}

void Transport::flush(milliseconds deadline) {
  std::unique_lock lock(mutex_);
  outgoing_done_.wait_for(lock, deadline, [this] { return outgoing_.empty() || !lost_.empty(); });
}

void Transport::loop() {
  sigset_t for_the_program; // signals go to the other threads: here one would end a poll
  sigemptyset(&for_the_program);
  sigaddset(&for_the_program, SIGINT);
  sigaddset(&for_the_program, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &for_the_program, nullptr);
  std::array<zmq::pollitem_t, 3> items{{{socket_.handle(), 0, ZMQ_POLLIN, 0},
                                        {wake_out_.handle(), 0, ZMQ_POLLIN, 0},
                                        {monitor_.handle(), 0, ZMQ_POLLIN, 0}}};
  while (true) {
    if (const auto waited = wait_for(items); !waited) return lose(waited.error().message);
    if ((items[1].revents & ZMQ_POLLIN) != 0) {
      zmq::message_t ignored;
      while (wake_out_.recv(ignored, zmq::recv_flags::dontwait)) {
      }
    }
    send_outgoing();
    {
      const std::lock_guard lock(mutex_);
      if (stop_) return;
    }
    if ((items[0].revents & ZMQ_POLLIN) != 0) {
      auto received = wire::receive(socket_, false);
      if (!received)
        lose(received.error().message);
      else if (*received)
        take(std::move((**received).message));
    }
    if ((items[2].revents & ZMQ_POLLIN) != 0) follow_connection();
    beat();
    leave_if_abandoned();
  }
}

/// A request seen before is answered from the cache (or ignored while the solver works on it); every other
/// one goes to the solver.
void Transport::take(wire::Message request) {
  const std::uint64_t id = request.envelope.request_id();
  if (id != 0 && id == working_on_) return;
  if (id != 0 && id == last_answer_.request) {
    if (const auto sent = wire::send(socket_, "", last_answer_.frames, send_deadline); !sent)
      lose(sent.error().message);
    return;
  }
  working_on_ = id;
  last_request_.envelope = request.envelope;
  last_request_.envelope.clear_array();
  report_progress("");
  last_beat_ = steady_clock::now();
  {
    const std::lock_guard lock(mutex_);
    incoming_.push_back(std::move(request));
  }
  incoming_ready_.notify_one();
}

void Transport::send_outgoing() {
  while (true) {
    Outgoing outgoing;
    {
      const std::lock_guard lock(mutex_);
      if (outgoing_.empty()) break;
      outgoing = std::move(outgoing_.front()); // its place stays in the queue until it is sent: for flush()
    }
    if (const auto sent = wire::send(socket_, "", outgoing.frames, send_deadline); !sent)
      lose(sent.error().message);
    if (outgoing.request != 0) {
      working_on_ = 0;
      last_answer_ = std::move(outgoing);
    }
    {
      const std::lock_guard lock(mutex_);
      outgoing_.pop_front();
    }
    outgoing_done_.notify_all();
  }
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
  {
    const std::lock_guard lock(mutex_);
    if (!lost_.empty()) return;
    lost_ = why;
  }
  lost_at_ = steady_clock::now();
  incoming_ready_.notify_all();
  outgoing_done_.notify_all();
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
