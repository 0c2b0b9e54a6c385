// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <zmq.hpp>

#include "common/base/result.hpp"
#include "coupler/launcher/authenticator.hpp"
#include "coupler/launcher/process.hpp"
#include "participant/cpp/keys.hpp"
#include "participant/cpp/protocol_state.hpp"
#include "participant/cpp/wire.hpp"

namespace drogue::launcher {

using Seconds = std::chrono::duration<double>;

/// One participant as the coupler sees it: its process, what it said of itself, its state, the request it
/// works on.
struct Peer {
  std::string name; ///< "fluid", "structure" or "mesh_mover"; also its identity on the socket
  std::filesystem::path log_file;
  std::optional<Process> process; ///< nothing for a participant that is started by hand
  std::vector<Watch> ranks;       ///< processes it named in Hello, other than the one started
  v1::Hello hello;
  participant::ProtocolState state = participant::ProtocolState::connected;

  // The outstanding request; request 0 is none.
  std::uint64_t request = 0;
  std::uint64_t answered = 0; ///< the last request that was answered
  v1::Envelope::BodyCase request_body = v1::Envelope::BODY_NOT_SET;
  v1::Envelope where;           ///< step, iteration and attempt of the request
  std::optional<v1::Beat> beat; ///< the last one since the request
  std::optional<wire::Message> answer;
  bool overdue = false;      ///< it did not end by itself when it was told to
  int connection = -1;       ///< started by hand: the descriptor over which it said Hello
  bool disconnected = false; ///< started by hand: that connection is gone
  double busy_seconds = 0;   ///< time spent working on requests, for the summary
  std::chrono::steady_clock::time_point asked_at{};

  /// Of all its processes on this machine together [MB].
  [[nodiscard]] double peak_memory_mb() const;
  /// "fluid (pid 12)", "fluid (started by hand)".
  [[nodiscard]] std::string text() const;
};

/// Where participants that are started by hand find the coupler.
struct Door {
  std::string endpoint;             ///< "tcp://HOST:PORT", PORT * for any; empty: none is started by hand
  std::optional<keys::KeyPair> key; ///< the coupler's; without it nobody on another machine may connect
  std::map<std::string, std::string> allowed; ///< participant by public key
};

/// Receives every message of a run as it travels.
class Witness {
 public:
  virtual ~Witness() = default;
  virtual Result<void> sent(const std::string& participant, const wire::Frames& frames) = 0;
  virtual Result<void> received(const std::string& participant, const wire::Frames& frames) = 0;
};

/// The coupler's socket and its participants: starts them, sends requests, and waits for answers while
/// watching every process. Whatever goes wrong first is the error, and it names the culprit; it is retryable
/// when a participant died or fell silent, so that a new start may help.
class Hub {
 public:
  /// Binds the socket. Errors: ErrorKind::config, the door's address is taken, is not this machine's, or can
  /// be reached from others while there is no key.
  /// @param run_id identity of the run; messages of another run are refused
  /// @param witness of all messages, or nullptr; must outlive the hub
  [[nodiscard]] static Result<std::unique_ptr<Hub>> create(std::string run_id, const Door& door = {},
                                                           Witness* witness = nullptr);
  ~Hub();

  [[nodiscard]] const std::string& endpoint() const { return endpoint_; }
  /// Where participants that are started by hand connect; empty without a door.
  [[nodiscard]] const std::string& door_endpoint() const { return door_endpoint_; }
  [[nodiscard]] const std::string& run_id() const { return run_id_; }
  /// Starts a participant; its Hello is awaited by await_hello.
  [[nodiscard]] Result<Peer*> start(const std::string& name, const Command& command);
  /// A participant that somebody else starts.
  [[nodiscard]] Peer* expect(const std::string& name);
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
  Hub(std::string run_id, Witness* witness) : run_id_(std::move(run_id)), witness_(witness) {}
  [[nodiscard]] Result<void> open(const Door& door);
  [[nodiscard]] Result<void> open_door(const Door& door);
  /// One wait for messages and process ends, until `deadline`. False on timeout.
  [[nodiscard]] Result<bool> turn(std::chrono::steady_clock::time_point deadline);
  /// Takes one waiting message; false when none is there.
  [[nodiscard]] Result<bool> take_one();
  [[nodiscard]] Result<void> take(Peer& peer, wire::Message message);
  [[nodiscard]] Result<void> hear_hello(Peer& peer, const v1::Hello& hello, int connection);
  [[nodiscard]] Result<void> check_alive();
  [[nodiscard]] Result<void> check_process(Peer& peer);
  void follow_connections();
  [[nodiscard]] Result<void> take_last_words(Peer& peer);
  [[nodiscard]] Error refusal(const Peer& peer) const;
  [[nodiscard]] Error death(const Peer& peer, const std::string& who, const std::string& how,
                            bool retryable) const;
  [[nodiscard]] Result<void> send(Peer& peer, wire::Message message, std::chrono::milliseconds deadline);
  void wait_for_end(Peer& peer, std::chrono::steady_clock::time_point end);
  [[nodiscard]] Error lateness(const Peer& peer, const std::string& what, Seconds deadline) const;
  void close_all(Seconds deadline, const std::function<void(v1::Envelope&)>& body);

  std::string run_id_, endpoint_, door_endpoint_;
  Witness* witness_;
  std::filesystem::path socket_folder_;
  zmq::context_t context_;
  Authenticator authenticator_;
  bool has_keys_ = false;
  zmq::socket_t monitor_, router_;
  std::vector<std::unique_ptr<Peer>> peers_;
  std::uint64_t last_request_ = 0;
};

/// "BeginStep of step 3", "Iterate of step 3, iteration 2".
[[nodiscard]] std::string request_text(v1::Envelope::BodyCase body, const v1::Envelope& where);

} // namespace drogue::launcher
