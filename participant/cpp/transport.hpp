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

/// A participant's socket. The solver's thread waits for requests and sends answers itself, so that no time
/// is lost between threads; while it works, another thread stands in for it: it beats, notices when the
/// coupler is gone, and takes care of repeated requests.
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
  /// Sends a message to the coupler; fills in run and participant. For the solver's thread.
  void post(wire::Message message);

 private:
  [[nodiscard]] Result<void> set_keys();
  void connect();
  void stand_in();
  void turn(std::chrono::milliseconds wait);
  void take(wire::Message request);
  void beat();
  void lose(const std::string& why);
  void follow_connection();
  void leave_if_abandoned() const;

  std::string endpoint_, participant_, run_id_, key_file_, coupler_key_;
  zmq::context_t context_;
  zmq::socket_t socket_, monitor_;
  std::thread thread_;

  std::mutex stop_mutex_;
  std::condition_variable stopped_;
  bool stop_ = false;

  std::mutex mutex_; // who holds it uses the sockets, and all below
  std::deque<wire::Message> incoming_;
  std::string lost_;             // why the coupler is gone; empty while it is there
  std::uint64_t working_on_ = 0; // request handed to the solver and not answered yet
  std::uint64_t last_answered_ = 0;
  wire::Frames last_answer_;
  bool connected_ = false;     // the coupler has taken the connection, with its keys
  wire::Message last_request_; // identity of the request in work, for the beats
  std::chrono::steady_clock::time_point last_beat_{}, lost_at_{};
};

} // namespace drogue::participant
