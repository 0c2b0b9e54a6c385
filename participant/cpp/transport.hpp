// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <zmq.hpp>

#include "common/base/result.hpp"
#include "participant/cpp/wire.hpp"

namespace drogue::participant {

/// The thread that owns a participant's socket: it hands requests to the solver's thread one by one, sends
/// the solver's answers, answers a repeated request from its cache, beats while the solver works, and notices
/// when the coupler is gone.
class Transport {
 public:
  explicit Transport(const ServeOptions& options);
  ~Transport();
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;

  /// Connects and starts the thread. Errors: ErrorKind::config, an endpoint on another machine without keys,
  /// or a bad key.
  [[nodiscard]] Result<void> start();
  /// Waits passively for the next request. Errors (ErrorKind::peer): silence for `deadline`, a lost coupler;
  /// interrupted: a signal came (common/base/interrupt.hpp).
  [[nodiscard]] Result<wire::Message> next_request(std::chrono::seconds deadline);
  /// Queues a message to the coupler and wakes the thread; fills in run and participant. For the solver's
  /// thread.
  void post(wire::Message message);
  /// Waits until everything posted was handed to the socket, at most `deadline`.
  void flush(std::chrono::milliseconds deadline);

 private:
  /// A message on its way out, encoded. What is no answer has request 0.
  struct Outgoing {
    std::uint64_t request = 0;
    wire::Frames frames;
  };
  [[nodiscard]] Result<void> set_keys();
  void connect();
  void loop();
  void enqueue(Outgoing outgoing);
  void take(wire::Message request);
  void send_outgoing();
  void beat();
  void lose(const std::string& why);
  void follow_connection();
  void leave_if_abandoned() const;

  std::string endpoint_, participant_, run_id_, key_file_, coupler_key_;
  zmq::context_t context_;
  zmq::socket_t socket_, wake_in_, wake_out_, monitor_;
  std::thread thread_;

  std::mutex mutex_;
  std::condition_variable incoming_ready_, outgoing_done_;
  std::deque<wire::Message> incoming_;
  std::deque<Outgoing> outgoing_;
  std::string lost_; // why the coupler is gone; empty while it is there
  bool stop_ = false;

  // Used by the thread alone.
  std::uint64_t working_on_ = 0; // request handed to the solver and not answered yet
  Outgoing last_answer_;
  bool connected_ = false;     // the coupler has taken the connection, with its keys
  wire::Message last_request_; // identity of the request in work, for the beats
  std::chrono::steady_clock::time_point last_beat_{}, lost_at_{};
};

} // namespace drogue::participant
