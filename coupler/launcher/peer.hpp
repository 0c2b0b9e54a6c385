// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <zmq.hpp>

#include "common/base/result.hpp"
#include "coupler/launcher/process.hpp"
#include "participant/cpp/protocol_state.hpp"
#include "participant/cpp/wire.hpp"

namespace drogue::launcher {

using Seconds = std::chrono::duration<double>;

/// One participant as the coupler sees it: its process, what it said of itself, its state, the request it
/// works on.
struct Peer {
  std::string name; ///< "fluid", "structure" or "mesh_mover"; also its identity on the socket
  std::filesystem::path log_file;
  std::optional<Process> process;
  std::vector<Watch> ranks; ///< processes it named in Hello, other than the one started
  v1::Hello hello;
  participant::ProtocolState state = participant::ProtocolState::connected;

  // The outstanding request; request 0 is none.
  std::uint64_t request = 0;
  std::uint64_t answered = 0; ///< the last request that was answered
  v1::Envelope::BodyCase request_body = v1::Envelope::BODY_NOT_SET;
  v1::Envelope where;           ///< step, iteration and attempt of the request
  std::optional<v1::Beat> beat; ///< the last one since the request
  std::optional<wire::Message> answer;
  bool overdue = false;    ///< it did not end by itself when it was told to
  double busy_seconds = 0; ///< time spent working on requests, for the summary
  std::chrono::steady_clock::time_point asked_at{};

  /// Of all its processes on this machine together [MB].
  [[nodiscard]] double peak_memory_mb() const;
};

/// The coupler's socket and its participants: starts them, sends requests, and waits for answers while
/// watching every process. Whatever goes wrong first is the error, and it names the culprit; it is retryable
/// when a participant died or fell silent, so that a new start may help.
class Hub {
 public:
  /// Binds the socket. @param run_id identity of the run; messages of another run are refused
  [[nodiscard]] static Result<std::unique_ptr<Hub>> create(std::string run_id);
  ~Hub();

  [[nodiscard]] const std::string& endpoint() const { return endpoint_; }
  [[nodiscard]] const std::string& run_id() const { return run_id_; }
  /// Starts a participant; its Hello is awaited by await_hello.
  [[nodiscard]] Result<Peer*> start(const std::string& name, const Command& command);
  [[nodiscard]] Result<void> await_hello(Peer& peer, Seconds deadline);

  /// Sends a request without waiting. @pre the peer has no outstanding request
  [[nodiscard]] Result<void> post(Peer& peer, wire::Message request);
  /// Waits for the answer to the outstanding request. An Error answer becomes an Error of the fitting kind
  /// (retryable numerical errors keep that mark).
  [[nodiscard]] Result<wire::Message> await(Peer& peer, Seconds deadline);
  [[nodiscard]] Result<wire::Message> ask(Peer& peer, wire::Message request, Seconds deadline);

  /// Asks everyone to shut down, waits at most `deadline`, kills who stays. Errors (ErrorKind::peer): who did
  /// not end well.
  [[nodiscard]] Result<void> shut_down(Seconds deadline);
  /// Tells everyone why, waits briefly, kills who stays.
  void abort(const std::string& reason);

  /// Set by a signal handler: waits end with ErrorKind::interrupted.
  static void interrupt() noexcept;
  [[nodiscard]] static bool interrupted() noexcept;

  [[nodiscard]] const std::vector<std::unique_ptr<Peer>>& peers() const { return peers_; }

 private:
  explicit Hub(std::string run_id) : run_id_(std::move(run_id)) {}
  /// One wait for messages and process ends, until `deadline`. False on timeout.
  [[nodiscard]] Result<bool> turn(std::chrono::steady_clock::time_point deadline);
  [[nodiscard]] Result<void> take(wire::Message message);
  [[nodiscard]] Result<void> check_alive();
  [[nodiscard]] Result<void> take_last_words(Peer& peer);
  [[nodiscard]] Error refusal(const Peer& peer) const;
  [[nodiscard]] Error death(const Peer& peer, pid_t pid, const std::string& how, bool retryable) const;
  [[nodiscard]] Error lateness(const Peer& peer, const std::string& what, Seconds deadline) const;
  void close_all(Seconds deadline, const std::function<void(v1::Envelope&)>& body);

  std::string run_id_, endpoint_;
  std::filesystem::path socket_folder_;
  zmq::context_t context_;
  zmq::socket_t router_;
  std::vector<std::unique_ptr<Peer>> peers_;
  std::uint64_t last_request_ = 0;
};

/// "BeginStep of step 3", "Iterate of step 3, iteration 2".
[[nodiscard]] std::string request_text(v1::Envelope::BodyCase body, const v1::Envelope& where);

} // namespace drogue::launcher
