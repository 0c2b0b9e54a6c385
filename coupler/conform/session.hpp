// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <zmq.hpp>

#include "common/base/result.hpp"
#include "coupler/launcher/process.hpp"
#include "participant/cpp/wire.hpp"

namespace drogue::coupler::conform {

using Seconds = std::chrono::duration<double>;

/// The participant under test, and how it is started.
struct Subject {
  std::vector<std::string> command; ///< arguments[0] is the program, as found by launcher::find_program
  std::string role;                 ///< "fluid", "structure" or "mesh_mover"
  std::filesystem::path folder;     ///< of everything that is written
  double deadline = 60;             ///< seconds for each answer
};

/// One life of the participant: its process, and a coupler's socket on which anything can be sent, right or
/// wrong.
class Session {
 public:
  /// Starts the participant in a folder of its own, SUBJECT.folder/LABEL.
  /// @param peer_deadline seconds, DROGUE_PEER_DEADLINE
  [[nodiscard]] static Result<std::unique_ptr<Session>>
  start(const Subject& subject, const std::string& label, int peer_deadline = 600);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  [[nodiscard]] const std::string& run_id() const { return run_id_; }
  /// For each answer [seconds].
  [[nodiscard]] double deadline() const { return subject_.deadline; }
  /// Where the participant may write its results, absolute.
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  /// Sends a request with the next number, for this run and participant unless the envelope says otherwise.
  [[nodiscard]] Result<std::uint64_t> send(wire::Message request);
  /// Sends a request that was sent before once more, with its number.
  [[nodiscard]] Result<void> repeat();
  /// Sends frames as they are.
  [[nodiscard]] Result<void> send_frames(const std::vector<std::string>& frames);
  /// The next message that is no Beat. Errors (ErrorKind::peer): the process ended, none came in time, it is
  /// malformed.
  [[nodiscard]] Result<wire::Message> receive(Seconds deadline);
  /// Sends a request and gives its answer: an Error too is an answer.
  [[nodiscard]] Result<wire::Message> ask(wire::Message request);
  /// The coupler disappears.
  void disappear();
  /// How the participant ended. Errors (ErrorKind::peer): it did not within the deadline.
  [[nodiscard]] Result<launcher::Exit> end(Seconds deadline);
  [[nodiscard]] bool ended() { return process_->poll().has_value(); }

  /// Its last Hello.
  [[nodiscard]] const v1::Hello& greeting() const { return greeting_; }
  /// Why messages so far broke the promise of identity; empty while none did.
  [[nodiscard]] const std::string& misnamed() const { return misnamed_; }
  /// Beats since the start, and the longest time an answer took [seconds] with the beats in that time.
  [[nodiscard]] double longest_work() const { return longest_work_; }
  [[nodiscard]] int beats_then() const { return beats_then_; }

 private:
  Session(const Subject& subject, std::filesystem::path folder)
      : subject_(subject), folder_(std::move(folder)) {}
  [[nodiscard]] Result<void> open(int peer_deadline);
  void check_identity(const wire::Message& message);

  const Subject& subject_;
  std::filesystem::path folder_, socket_folder_;
  std::string run_id_;
  zmq::context_t context_;
  zmq::socket_t router_;
  std::optional<launcher::Process> process_;
  wire::Message last_sent_;
  std::uint64_t last_request_ = 0;
  v1::Hello greeting_;
  std::string misnamed_;
  bool raw_ = false; ///< frames were sent as they are: numbers of answers mean nothing any more
  int beats_ = 0, beats_then_ = 0;
  double longest_work_ = 0;
};

/// What an answer is, for reports: "Done", "Error WRONG_STATE (TEXT)".
[[nodiscard]] std::string answer_text(const wire::Message& answer);

} // namespace drogue::coupler::conform
